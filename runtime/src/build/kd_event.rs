use restpose_formats::geom::Aabb;

/// A place where a box begins or ends along one axis, in eight bytes.
///
/// ```text
/// [63..32] position, its bits mapped so that they sort as the numbers do
/// [31..2]  box
/// [1]      the box ends here    [0] the box begins here    (both: it is planar)
/// ```
///
/// As integers, events sort by position, then by box, then beginnings first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event(u64);

const BEGINS: u64 = 1;
const ENDS: u64 = 2;

/// Fewer events are sorted by comparison: measured break-even with the passes of [`radix_sort`].
const RADIX_MIN: usize = 512;

impl Event {
    fn new(position: f32, id: u32, kind: u64) -> Self {
        let bits = position.to_bits();
        let key = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        Self(u64::from(key) << 32 | u64::from(id) << 2 | kind)
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
        (self.0 as u32 >> 2) as usize
    }

    /// 1 when a box begins here, else 0.
    #[inline]
    pub(super) fn begins(self) -> u32 {
        self.0 as u32 & 1
    }

    /// 1 when a box ends here, else 0.
    #[inline]
    pub(super) fn ends(self) -> u32 {
        self.0 as u32 >> 1 & 1
    }

    #[inline]
    pub(super) fn is_planar(self) -> bool {
        self.0 & (BEGINS | ENDS) == BEGINS | ENDS
    }
}

/// Appends the events of `bounds` along `axis`: one if it is planar there, else two.
pub(super) fn push_events(list: &mut Vec<Event>, bounds: &Aabb, axis: usize, id: u32) {
    let (min, max) = (bounds.min[axis], bounds.max[axis]);
    if min == max {
        list.push(Event::new(min, id, BEGINS | ENDS));
    } else {
        list.push(Event::new(min, id, BEGINS));
        list.push(Event::new(max, id, ENDS));
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

/// Least significant digit first over the four bytes of the position. Stable, so boxes keep their order and the result
/// is that of sorting whole events; an even number of passes, so it ends up in `list`.
fn radix_sort(list: &mut [Event], spare: &mut [Event]) {
    let mut counts = [[0u32; 256]; 4];
    for event in list.iter() {
        for (digit, count) in counts.iter_mut().enumerate() {
            count[byte(*event, digit)] += 1;
        }
    }
    let (mut from, mut to) = (list, spare);
    for (digit, count) in counts.iter_mut().enumerate() {
        let mut next = 0;
        for place in count.iter_mut() {
            next += std::mem::replace(place, next);
        }
        for event in from.iter() {
            let place = &mut count[byte(*event, digit)];
            to[*place as usize] = *event;
            *place += 1;
        }
        std::mem::swap(&mut from, &mut to);
    }
}

#[inline]
fn byte(event: Event, digit: usize) -> usize {
    (event.0 >> (32 + 8 * digit)) as usize & 0xff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_sort_as_positions_do_and_decode_to_them() {
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
        for pair in ascending.windows(2) {
            assert!(
                Event::new(pair[0], u32::MAX >> 2, ENDS) < Event::new(pair[1], 0, BEGINS),
                "{pair:?}"
            );
        }
        for x in ascending {
            let event = Event::new(x, 77, ENDS);
            assert_eq!(
                (event.position(), event.id(), event.begins(), event.ends()),
                (x, 77, 0, 1)
            );
        }
        assert!(Event::new(0.0, u32::MAX >> 2, BEGINS | ENDS).is_planar());
        assert_eq!(Event::new(0.0, u32::MAX >> 2, BEGINS).id(), (u32::MAX >> 2) as usize);
    }

    #[test]
    fn radix_sort_orders_whole_events() {
        let mut state = 1u32;
        let mut list = Vec::new();
        for id in 0..3000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let a = (state >> 20) as f32 - 2000.0;
            let b = a + (state >> 8 & 3) as f32;
            push_events(
                &mut list,
                &Aabb {
                    min: [a; 3],
                    max: [b; 3],
                },
                1,
                id,
            );
        }
        let mut expected = list.clone();
        expected.sort();
        let mut spare = vec![Event::default(); list.len()];
        radix_sort(&mut list, &mut spare);
        assert_eq!(list, expected);
    }
}
