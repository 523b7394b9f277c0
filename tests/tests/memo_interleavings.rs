//! The memo of posed vertices, which threads share without waiting, in every order in which its atomics may run: by `loom`,
//! which also lets a relaxed load see old values. A thread is interrupted twice at most: without a bound there are more
//! orders than can be tried.

#[path = "../../runtime/src/vertex_memo.rs"]
mod vertex_memo;

mod atomic {
    pub use loom::sync::atomic::{AtomicU32, Ordering};
}

use loom::{sync::Arc, thread};
use vertex_memo::VertexMemo;

const EARLIER: [f32; 3] = [7.0, 8.0, 9.0];

fn position(vertex: u32) -> [f32; 3] {
    [vertex as f32, 1.0, 2.0]
}

/// A memo whose vertices hold what they were in an earlier frame.
fn memo(vertices: u32) -> VertexMemo {
    let mut memo = VertexMemo::default();
    memo.begin(vertices as usize);
    for vertex in 0..vertices {
        memo.keep(vertex, EARLIER);
    }
    memo.begin(vertices as usize);
    assert_eq!(memo.frame, 2);
    memo
}

/// What a ray does that needs a vertex.
fn take(memo: &VertexMemo, vertex: u32) -> [f32; 3] {
    memo.position(vertex).unwrap_or_else(|| {
        memo.keep(vertex, position(vertex));
        position(vertex)
    })
}

fn in_all_orders(vertices: u32, threads: [&'static [u32]; 2]) {
    let mut model = loom::model::Builder::new();
    model.preemption_bound = Some(2);
    model.check(move || {
        let memo = Arc::new(memo(vertices));
        let threads = threads.map(|asked| {
            let memo = Arc::clone(&memo);
            thread::spawn(move || {
                for vertex in asked {
                    assert_eq!(take(&memo, *vertex), position(*vertex));
                }
            })
        });
        for thread in threads {
            thread.join().unwrap();
        }
        for vertex in 0..vertices {
            assert_eq!(take(&memo, vertex), position(vertex));
        }
    });
}

#[test]
fn threads_that_want_one_vertex_get_it_whole() {
    in_all_orders(1, [&[0], &[0]]);
}

#[test]
fn threads_that_come_again_get_what_was_posed() {
    in_all_orders(1, [&[0, 0], &[0]]);
}

#[test]
fn threads_cross() {
    in_all_orders(2, [&[0, 1], &[1, 0]]);
}
