mod arm;
mod half_turns;
mod joint_limit_files;
mod random_poses;
mod rotations;
mod without_clips;
