use crate::vertex_memo::VertexMemo;

#[test]
fn a_position_is_kept_for_its_frame() {
    let mut memo = VertexMemo::default();
    memo.begin(2);
    assert_eq!(memo.position(1), None);
    memo.keep(1, [1.0, 2.0, 3.0]);
    assert_eq!((memo.position(1), memo.position(0)), (Some([1.0, 2.0, 3.0]), None));
    memo.begin(2);
    assert_eq!(memo.position(1), None);
}

#[test]
fn stamps_of_an_earlier_round_are_not_taken_for_new() {
    let mut memo = VertexMemo::default();
    memo.begin(1);
    memo.keep(0, [1.0; 3]);
    memo.frame = u32::MAX;
    memo.begin(1);
    assert_eq!((memo.frame, memo.position(0)), (1, None));
}
