mod arm;
mod joint_limit_files;
mod random_poses;
mod rotations;
mod without_clips;
