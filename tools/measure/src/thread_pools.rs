use crate::MeasureError;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Most threads of one pool.
pub(crate) const THREAD_LIMIT: usize = 1024;

/// A pool for each number of threads.
pub(crate) fn thread_pools(threads: &[usize]) -> Result<Vec<ThreadPool>, MeasureError> {
    let pool = |threads: &usize| {
        let pool = ThreadPoolBuilder::new().num_threads(*threads).build();
        pool.map_err(|source| MeasureError::Threads {
            threads: *threads,
            source,
        })
    };
    threads.iter().map(pool).collect()
}

/// One thread, and as many as the current pool has.
pub(crate) fn one_and_all() -> Vec<usize> {
    let mut threads = vec![1, rayon::current_num_threads()];
    threads.dedup();
    threads
}
