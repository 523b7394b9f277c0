use crate::vertex_memo::VertexMemo;

#[test]
fn a_vertex_is_posed_once_per_frame() {
    let mut memo = VertexMemo::default();
    memo.begin(2);
    assert_eq!(memo.position(1, || [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    assert_eq!(memo.position(1, || panic!("known")), [1.0, 2.0, 3.0]);
    assert_eq!(memo.position(0, || [4.0; 3]), [4.0; 3]);
    memo.begin(2);
    assert_eq!(memo.position(1, || [5.0; 3]), [5.0; 3]);
}

#[test]
fn stamps_of_an_earlier_round_are_not_taken_for_new() {
    let mut memo = VertexMemo::default();
    memo.begin(1);
    memo.position(0, || [1.0; 3]);
    memo.frame = u32::MAX;
    memo.begin(1);
    assert_eq!((memo.frame, memo.position(0, || [2.0; 3])), (1, [2.0; 3]));
}
