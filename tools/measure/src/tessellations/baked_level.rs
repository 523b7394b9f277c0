use crate::MeasureError;
use rayon::ThreadPool;
use restpose_bake::{BakeReport, BakeSettings, NoProgress, bake, import::Animation, subdivide::subdivide};
use restpose_formats::{TreeKind, write};
use restpose_runtime::Asset;
use std::{sync::Arc, time::Instant};

/// One tessellation, baked in every pool.
pub(super) struct BakedLevel {
    pub subdivisions: u32,
    pub asset: Arc<Asset>,
    pub report: BakeReport,
    pub file_bytes: u64,
    /// Of the bake, per pool.
    pub seconds: Vec<f64>,
}

impl BakedLevel {
    /// Bakes in each pool and sees that the files are the same.
    pub(super) fn new(
        animation: &Animation,
        subdivisions: u32,
        tree: TreeKind,
        pools: &[ThreadPool],
    ) -> Result<Self, MeasureError> {
        let [first, others @ ..] = pools else {
            return Err(MeasureError::Setting {
                name: "number of thread counts",
                found: 0,
                expected: "1 or more",
            });
        };
        let mesh = subdivide(animation, subdivisions);
        let settings = BakeSettings {
            tree,
            ..BakeSettings::default()
        };
        let mut seconds = Vec::with_capacity(pools.len());
        let mut timed = |pool: &ThreadPool| -> Result<(Vec<u8>, BakeReport), MeasureError> {
            let start = Instant::now();
            let baked = pool.install(|| bake(&mesh, &settings, &NoProgress))?;
            seconds.push(start.elapsed().as_secs_f64());
            Ok((write(&baked.model)?, baked.report))
        };
        let (bytes, report) = timed(first)?;
        for pool in others {
            if timed(pool)?.0 != bytes {
                return Err(MeasureError::BakeDiffers {
                    subdivisions,
                    first: first.current_num_threads(),
                    threads: pool.current_num_threads(),
                });
            }
        }
        Ok(Self {
            subdivisions,
            asset: Arc::new(Asset::from_bytes(&bytes)?),
            report,
            file_bytes: bytes.len() as u64,
            seconds,
        })
    }
}
