use super::{Lanes, Portable};

/// The bits of all results of all operations.
fn everything<S: Lanes>(simd: S, a: &[f32; 8], b: &[f32; 8]) -> Vec<u32> {
    let (wide_a, wide_b) = (simd.load8(a), simd.load8(b));
    let mut max = [0.0; 8];
    simd.store8(simd.max8(wide_a, wide_b), &mut max);
    let mut counted = [0.0; 8];
    simd.store8(simd.max8_counting(wide_a, wide_b), &mut counted);
    let wide = [
        simd.add8(wide_a, wide_b),
        simd.sub8(wide_a, wide_b),
        simd.mul8(wide_a, wide_b),
        simd.min8(wide_a, wide_b),
        simd.div8(wide_a, wide_b),
        simd.splat8(a[2]),
        simd.join(simd.halves(wide_b)[1], simd.halves(wide_a)[0]),
        simd.widen8(&a.map(|x| x as u16)),
        simd.widen8_bytes(&a.map(|x| x as u8)),
    ];
    let [x, y] = simd.halves(wide_a);
    let z = simd.halves(wide_b)[0];
    let vectors = [
        simd.add4(x, y),
        simd.sub4(x, z),
        simd.mul4(y, z),
        simd.min4(x, z),
        simd.max4(x, z),
        simd.splat4(a[1]),
        simd.rotate4(x),
    ];
    let mut out: Vec<f32> = max.iter().chain(&counted[..7]).copied().collect();
    for vector in wide {
        let mut eight = [0.0; 8];
        simd.store8(vector, &mut eight);
        out.extend(eight);
    }
    out.extend(vectors.iter().flat_map(|vector| simd.store4(*vector)));
    for (low, high) in [(wide_a, wide_b), (wide_b, wide_a), (wide_a, wide_a)] {
        let (mut numbers, mut tags) = ([0.0; 8], [0; 8]);
        let count = simd.sort8(low, high, &[10, 11, 12, 13, 14, 15, 16, 17], (&mut numbers, &mut tags));
        out.extend(&numbers[..count]);
        out.extend(tags[..count].iter().map(|tag| *tag as f32));
    }
    out.push(simd.pair_products(x));
    // Of NaN only that it is one.
    let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
    let mut out: Vec<u32> = out.into_iter().map(bits).collect();
    out.push(counted[7].to_bits());
    out.extend([simd.le8(wide_a, wide_b), simd.lt8(wide_a, wide_b)]);
    let rows = [wide_a, wide_b, wide_b, wide_a, wide[1], wide[2], wide_b, wide[3]];
    for vector in simd.transpose8(rows) {
        let mut eight = [0.0; 8];
        simd.store8(vector, &mut eight);
        out.extend(eight.map(bits));
    }
    let [x, y] = [x, z].map(|four| simd.to_f64(four));
    let doubles = [
        x,
        simd.add4_f64(x, y),
        simd.sub4_f64(x, y),
        simd.mul4_f64(x, y),
        simd.div4_f64(x, y),
        simd.splat4_f64(1.0 / f64::from(a[3])),
        simd.abs4_f64(y),
        simd.max4_f64(x, y),
        simd.load4_f64(&simd.store4_f64(y)),
    ];
    for double in doubles {
        out.extend(simd.store4(simd.to_f32(double)).map(bits));
        // What is lost above.
        let rest = simd.sub4_f64(double, simd.to_f64(simd.to_f32(double)));
        out.extend(simd.store4(simd.to_f32(rest)).map(bits));
    }
    out.push(simd.lt4_f64(x, y));
    for order in [wide_a, wide_b].map(|keys| simd.order8(keys)) {
        let moved = [
            simd.permute8(wide_a, order),
            simd.later8::<1>(order),
            simd.later8::<2>(wide_a),
            simd.later8::<4>(wide_b),
            simd.sooner8::<1>(wide_a),
            simd.sooner8::<2>(wide_b),
            simd.sooner8::<4>(order),
        ];
        for vector in moved {
            let mut eight = [0.0; 8];
            simd.store8(vector, &mut eight);
            out.extend(eight.map(bits));
        }
    }
    let small = simd.load4(&[a[0], a[1], a[2], a[3]].map(|x| if x.abs() < 1e9 { x } else { 1.5 }));
    out.extend(simd.truncate4(small).map(|x| x as u32));
    out
}

#[test]
fn instruction_sets_agree_on_every_operation() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::MAX,
        f32::MIN,
        f32::from_bits(1),
        f32::MIN_POSITIVE,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        0.999_999_94,
        7.5,
    ];
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..2000 {
        let mut pick = || match random.bool() {
            true => special[random.usize(..special.len())],
            false => (random.f32() - 0.5) * 100.0,
        };
        let (a, b) = (std::array::from_fn(|_| pick()), std::array::from_fn(|_| pick()));
        let expected = everything(Portable, &a, &b);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = super::Avx2::new() {
            assert_eq!(everything(simd, &a, &b), expected, "{a:?} {b:?}");
        }
    }
}

#[test]
fn lanes_are_ordered_permuted_and_moved_by_definition() {
    let a = [
        3.0,
        1.0,
        3.0f32.next_up(),
        -2.0,
        1.0,
        9.0,
        f32::INFINITY,
        f32::NEG_INFINITY,
    ];
    let order = Portable.order8(a);
    assert_eq!(order.map(f32::to_bits), [6, 5, 2, 0, 4, 1, 3, 7]);
    let names = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    assert_eq!(
        Portable.permute8(names, order),
        [6.0, 5.0, 2.0, 0.0, 4.0, 1.0, 3.0, 7.0]
    );
    assert_eq!(Portable.later8::<1>(names), [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(Portable.later8::<4>(names), [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
    assert_eq!(Portable.sooner8::<2>(names), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 6.0, 7.0]);
    assert_eq!(Portable.pair_products([2.0, 3.0, 5.0, 100.0]), 6.0 + 15.0 + 10.0);
}

/// By definition: of equal numbers the later lane comes first, and so of those that differ in their lowest bits alone.
#[test]
fn numbers_that_are_in_range_are_sorted_with_their_tags() {
    let a = [1.0f32, -2.0, 5.0, 1.0, 0.0, -0.0, f32::INFINITY, 1.0f32.next_up()];
    let b = [1.0f32, 0.0, 4.0, 9.0, 0.0, 0.0, f32::NAN, 2.0];
    let (mut numbers, mut tags) = ([0.0; 8], [0; 8]);
    let count = Portable.sort8(a, b, &[10, 11, 12, 13, 14, 15, 16, 17], (&mut numbers, &mut tags));
    assert_eq!(numbers[..count], [1.0f32.next_up(), 1.0, 1.0, 0.0, -0.0, -2.0]);
    assert_eq!(tags[..count], [17, 13, 10, 14, 15, 11]);
    let mut random = fastrand::Rng::with_seed(57);
    for _ in 0..2000 {
        let scale = 10f32.powi(random.i32(-30..30));
        let mut eight = || -> [f32; 8] { std::array::from_fn(|_| (random.f32() - 0.5) * scale) };
        let (a, b) = (eight(), eight());
        let count = Portable.sort8(a, b, &[0, 1, 2, 3, 4, 5, 6, 7], (&mut numbers, &mut tags));
        let mut expected: Vec<usize> = (0..8).filter(|lane| a[*lane] <= b[*lane]).collect();
        expected.sort_by(|one, other| a[*other].total_cmp(&a[*one]));
        let found: Vec<usize> = tags[..count].iter().map(|tag| *tag as usize).collect();
        // Random numbers are seldom within eight units in the last place; with this seed none are.
        assert_eq!(found, expected, "{a:?} {b:?}");
        assert!(found.iter().zip(&numbers).all(|(lane, number)| a[*lane] == *number));
    }
}
