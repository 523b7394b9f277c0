/// Both results; on two threads where there are, if it is `worth_a_task`.
pub(super) fn both<A: Send, B: Send>(
    worth_a_task: bool,
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "parallel")]
    if worth_a_task {
        return rayon::join(one, other);
    }
    #[cfg(not(feature = "parallel"))]
    let _ = worth_a_task;
    (one(), other())
}
