use restpose_formats::rows::KdNodeRow;

/// A place where a box begins or ends along one axis, in eight bytes.
///
/// ```text
/// [63..32] position, its bits mapped so that they sort as the numbers do
/// [31..30] 0: the box ends here   1: it lies in the plane   2: it begins here
/// [29..0]  box
/// ```
///
/// As integers, events sort by position, then by kind, then by box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event(u64);

const ENDS: u64 = 0;
const PLANAR: u64 = 1;
const BEGINS: u64 = 2;

/// Fewer events are sorted by comparison.
const RADIX_MIN: usize = 512;

impl Event {
    fn new(position: f32, id: u32, kind: u64) -> Self {
        let bits = position.to_bits();
        let key = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        Self(u64::from(key) << 32 | kind << 30 | u64::from(id))
    }

    /// The events of a box between `min` and `max` in a cell along one axis: one if it is planar, else up to two.
    /// Beginnings and ends on the border of the cell are left out.
    pub(super) fn of(id: u32, [min, max]: [f32; 2], cell: [f32; 2]) -> impl Iterator<Item = Self> {
        let planar = min == max;
        let first = if planar {
            Some(PLANAR)
        } else {
            (min > cell[0]).then_some(BEGINS)
        };
        let second = (!planar && max < cell[1]).then_some(ENDS);
        let first = first.map(|kind| Self::new(min, id, kind));
        first.into_iter().chain(second.map(|kind| Self::new(max, id, kind)))
    }

    /// Equal for events at equal positions.
    #[inline]
    pub(super) fn key(self) -> u32 {
        (self.0 >> 32) as u32
    }

    #[inline]
    pub(super) fn position(self) -> f32 {
        let key = self.key();
        f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
    }

    /// The box, as an index.
    #[inline]
    pub(super) fn id(self) -> usize {
        (self.0 as u32 & KdNodeRow::MAX_INDEX) as usize
    }

    /// 1 when a box begins here or lies in the plane, else 0.
    #[inline]
    pub(super) fn begins(self) -> u32 {
        u32::from(self.kind() != ENDS)
    }

    /// 1 when a box ends here or lies in the plane, else 0.
    #[inline]
    pub(super) fn ends(self) -> u32 {
        u32::from(self.kind() != BEGINS)
    }

    #[inline]
    pub(super) fn is_planar(self) -> bool {
        self.kind() == PLANAR
    }

    #[inline]
    fn digit(self, number: usize) -> usize {
        (self.0 >> (28 + 9 * number)) as usize & 0x1ff
    }

    #[inline]
    fn kind(self) -> u64 {
        self.0 >> 30 & 3
    }
}

/// Sorts events that stand in the order of their boxes.
pub(super) fn sort_events(list: &mut [Event], spare: &mut Vec<Event>) {
    if list.len() < RADIX_MIN {
        list.sort_unstable();
        return;
    }
    if spare.len() < list.len() {
        spare.resize(list.len(), Event::default());
    }
    radix_sort(list, &mut spare[..list.len()]);
}

/// Least significant digit first, 4 × 9 bits from bit 28 up: position, kind and two bits of the box. Stable, so boxes of
/// equal events keep their order and the result is that of sorting whole events; an even number of passes, so it ends up
/// in `list`.
fn radix_sort(list: &mut [Event], spare: &mut [Event]) {
    let mut counts = [[0u32; 512]; 4];
    for event in list.iter() {
        for (digit, count) in counts.iter_mut().enumerate() {
            count[event.digit(digit)] += 1;
        }
    }
    let (mut from, mut to) = (list, spare);
    for (digit, count) in counts.iter_mut().enumerate() {
        let mut next = 0;
        for place in count.iter_mut() {
            next += std::mem::replace(place, next);
        }
        for event in from.iter() {
            let place = &mut count[event.digit(digit)];
            to[*place as usize] = *event;
            *place += 1;
        }
        std::mem::swap(&mut from, &mut to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_sort_by_position_then_kind_then_box_and_decode() {
        let ascending = [
            f32::MIN,
            -1e30,
            -1.0,
            -1e-45,
            0.0,
            1e-45,
            1.0,
            1.0f32.next_up(),
            1e30,
            f32::MAX,
        ];
        let mut events = Vec::new();
        for position in ascending {
            for kind in [ENDS, PLANAR, BEGINS] {
                for id in [0, 1, KdNodeRow::MAX_INDEX] {
                    let event = Event::new(position, id, kind);
                    assert_eq!((event.position(), event.id()), (position, id as usize));
                    assert_eq!(
                        (event.begins(), event.ends()),
                        (u32::from(kind != 0), u32::from(kind != 2))
                    );
                    assert_eq!(event.is_planar(), kind == 1);
                    events.push(event);
                }
            }
        }
        assert!(events.is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn events_on_the_border_are_those_of_planar_boxes() {
        let events = |min: f32, max: f32| Event::of(5, [min, max], [0.0, 2.0]).collect::<Vec<_>>();
        assert_eq!(events(0.0, 2.0), []);
        assert_eq!(events(0.0, 0.0), [Event::new(0.0, 5, PLANAR)]);
        assert_eq!(events(0.0, 1.0), [Event::new(1.0, 5, ENDS)]);
        assert_eq!(events(1.0, 2.0), [Event::new(1.0, 5, BEGINS)]);
        assert_eq!(events(0.5, 1.0), [Event::new(0.5, 5, BEGINS), Event::new(1.0, 5, ENDS)]);
    }

    #[test]
    fn radix_sort_orders_whole_events() {
        let mut state = 1u32;
        let mut list = Vec::new();
        for id in 0..3000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let a = (state >> 20) as f32 - 2000.0;
            let b = a + (state >> 8 & 3) as f32;
            list.extend(Event::of(id, [a, b], [f32::MIN, f32::MAX]));
        }
        let mut expected = list.clone();
        expected.sort();
        let mut spare = vec![Event::default(); list.len()];
        radix_sort(&mut list, &mut spare);
        assert_eq!(list, expected);
    }
}
