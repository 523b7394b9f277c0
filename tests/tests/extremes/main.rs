//! Hits at the limits: rays, scales, numbers, clusters and top levels at which shortcuts break; and how precise they are.

mod crowded_top_level;
mod deep_chains;
mod extreme_numbers;
mod flat_clusters;
mod parallel_rays;
mod precision;
mod ray_extremes;
mod scale_extremes;
mod singular_palettes;
mod watertight;
