use serde::Serialize;

/// What a paper reports of a builder, on its own machines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TheirFigures {
    /// Paper and table.
    pub table: &'static str,
    /// Scene of the paper.
    pub scene: &'static str,
    /// Triangles.
    pub triangles: u32,
    /// Builder, by our name.
    pub builder: &'static str,
    /// Threads.
    pub threads: u32,
    /// Seconds of the exact builder.
    pub exact_seconds: f64,
    /// Seconds.
    pub seconds: f64,
    /// Speed of tracing relative to the exact tree, or its SAH cost over this tree's; none where not given.
    pub quality: Option<f64>,
}

const KD: &str = "Günther, Table 4.1";
const SHUFFLED: &str = "Günther, Table 4.1, shuffled";
const BVH: &str = "Günther, Table 4.2";
const WALD: &str = "Wald, Table 1";
const TRACKED: &str = "Hussain and Grahn, Table I";

/// A row.
const fn row(
    table: &'static str,
    (scene, triangles): (&'static str, u32),
    builder: &'static str,
    threads: u32,
    [exact_seconds, seconds]: [f64; 2],
    quality: Option<f64>,
) -> TheirFigures {
    TheirFigures {
        table,
        scene,
        triangles,
        builder,
        threads,
        exact_seconds,
        seconds,
        quality,
    }
}

/// Günther's Tables 4.1 and 4.2. The quality in the latter is that of the fast settings, as its text says.
const GUENTHER: [TheirFigures; 28] = [
    row(KD, ("HAND", 17_135), "kd-streamed", 1, [0.109, 0.103], Some(1.0)),
    row(KD, ("BUNNY", 69_451), "kd-streamed", 1, [0.611, 0.513], Some(0.99)),
    row(
        KD,
        ("FAIRY FOREST", 174_117),
        "kd-streamed",
        1,
        [1.32, 1.15],
        Some(0.989),
    ),
    row(KD, ("CONFERENCE", 282_664), "kd-streamed", 1, [1.55, 1.41], Some(0.984)),
    row(KD, ("BLADE", 1_765_388), "kd-streamed", 1, [7.52, 7.6], Some(0.992)),
    row(KD, ("BEETLE", 1_873_389), "kd-streamed", 1, [18.8, 15.3], Some(0.979)),
    row(
        KD,
        ("THAI STATUE", 10_000_000),
        "kd-streamed",
        1,
        [99.6, 80.8],
        Some(0.988),
    ),
    row(SHUFFLED, ("HAND", 17_135), "kd-streamed", 1, [0.112, 0.106], Some(1.0)),
    row(
        SHUFFLED,
        ("BUNNY", 69_451),
        "kd-streamed",
        1,
        [0.622, 0.520],
        Some(0.99),
    ),
    row(
        SHUFFLED,
        ("FAIRY FOREST", 174_117),
        "kd-streamed",
        1,
        [1.45, 1.18],
        Some(0.989),
    ),
    row(
        SHUFFLED,
        ("CONFERENCE", 282_664),
        "kd-streamed",
        1,
        [1.83, 1.48],
        Some(0.984),
    ),
    row(
        SHUFFLED,
        ("BLADE", 1_765_388),
        "kd-streamed",
        1,
        [10.4, 8.04],
        Some(0.992),
    ),
    row(
        SHUFFLED,
        ("BEETLE", 1_873_389),
        "kd-streamed",
        1,
        [22.0, 15.6],
        Some(0.979),
    ),
    row(
        SHUFFLED,
        ("THAI STATUE", 10_000_000),
        "kd-streamed",
        1,
        [123.0, 83.1],
        Some(0.988),
    ),
    row(BVH, ("BUNNY", 69_451), "bvh-streamed", 1, [0.168, 0.048], None),
    row(BVH, ("FAIRY FOREST", 174_117), "bvh-streamed", 1, [0.47, 0.12], None),
    row(BVH, ("CONFERENCE", 282_641), "bvh-streamed", 1, [0.80, 0.20], None),
    row(BVH, ("BUDDHA", 1_087_716), "bvh-streamed", 1, [4.38, 0.84], None),
    row(BVH, ("SODA HALL", 2_169_132), "bvh-streamed", 1, [8.78, 1.59], None),
    row(BVH, ("POWER PLANT", 12_748_510), "bvh-streamed", 1, [119.0, 8.1], None),
    row(
        BVH,
        ("BOEING 777", 348_216_139),
        "bvh-streamed",
        1,
        [5605.0, 667.0],
        None,
    ),
    row(
        BVH,
        ("BUNNY", 69_451),
        "bvh-streamed-fast",
        1,
        [0.168, 0.037],
        Some(0.989),
    ),
    row(
        BVH,
        ("FAIRY FOREST", 174_117),
        "bvh-streamed-fast",
        1,
        [0.47, 0.10],
        Some(0.988),
    ),
    row(
        BVH,
        ("CONFERENCE", 282_641),
        "bvh-streamed-fast",
        1,
        [0.80, 0.15],
        Some(0.925),
    ),
    row(
        BVH,
        ("BUDDHA", 1_087_716),
        "bvh-streamed-fast",
        1,
        [4.38, 0.66],
        Some(0.989),
    ),
    row(
        BVH,
        ("SODA HALL", 2_169_132),
        "bvh-streamed-fast",
        1,
        [8.78, 1.28],
        Some(1.035),
    ),
    row(
        BVH,
        ("POWER PLANT", 12_748_510),
        "bvh-streamed-fast",
        1,
        [119.0, 6.6],
        Some(0.994),
    ),
    row(
        BVH,
        ("BOEING 777", 348_216_139),
        "bvh-streamed-fast",
        1,
        [5605.0, 572.0],
        Some(0.948),
    ),
];

/// A scene of Wald's Table 1: seconds of the sweep; then of binned, BIH, hybrid on 1, 2, 4 and 8 threads and grid on 1, 2, 4
/// and 8 threads, seconds and speed of tracing.
type WaldScene = ((&'static str, u32), f64, [(f64, f64); 10]);

const WALD_BUILDERS: [(&str, u32); 10] = [
    ("bvh-binned", 1),
    ("bvh-median", 1),
    ("bvh-hybrid", 1),
    ("bvh-hybrid", 2),
    ("bvh-hybrid", 4),
    ("bvh-hybrid", 8),
    ("bvh-grid", 1),
    ("bvh-grid", 2),
    ("bvh-grid", 4),
    ("bvh-grid", 8),
];

const WALD_SCENES: [WaldScene; 5] = [
    (
        ("fairy", 174_000),
        0.86,
        [
            (0.083, 0.93),
            (0.036, 0.77),
            (0.098, 0.98),
            (0.061, 0.98),
            (0.042, 0.98),
            (0.070, 0.98),
            (0.087, 0.95),
            (0.045, 0.95),
            (0.030, 0.95),
            (0.021, 0.93),
        ],
    ),
    (
        ("conference", 282_000),
        1.32,
        [
            (0.139, 0.91),
            (0.065, 0.82),
            (0.167, 0.91),
            (0.095, 0.91),
            (0.063, 0.91),
            (0.096, 0.91),
            (0.151, 0.88),
            (0.078, 0.88),
            (0.044, 0.88),
            (0.026, 0.86),
        ],
    ),
    (
        ("exploding dragon", 252_000),
        1.16,
        [
            (0.109, 0.98),
            (0.044, 0.80),
            (0.128, 0.98),
            (0.074, 0.98),
            (0.047, 1.0),
            (0.070, 0.98),
            (0.110, 0.98),
            (0.057, 0.98),
            (0.031, 0.98),
            (0.020, 0.98),
        ],
    ),
    (
        ("blade", 1_500_000),
        10.2,
        [
            (1.09, 1.0),
            (0.412, 0.76),
            (1.16, 1.01),
            (0.615, 1.01),
            (0.392, 1.01),
            (0.294, 1.01),
            (0.971, 1.01),
            (0.491, 1.01),
            (0.284, 1.01),
            (0.152, 1.01),
        ],
    ),
    (
        ("thai", 10_000_000),
        82.0,
        [
            (7.4, 0.99),
            (3.3, 0.87),
            (7.9, 1.0),
            (4.2, 1.0),
            (2.7, 1.0),
            (1.9, 1.0),
            (6.8, 0.99),
            (3.5, 0.99),
            (2.0, 0.99),
            (1.1, 0.99),
        ],
    ),
];

/// Running builds, without the filter's own time.
const HUSSAIN: [TheirFigures; 4] = [
    row(TRACKED, ("Horse", 16_800), "kd-tracked", 1, [0.135, 0.030], None),
    row(TRACKED, ("Elephant", 84_600), "kd-tracked", 1, [0.710, 0.105], None),
    row(TRACKED, ("ClothBall", 92_200), "kd-tracked", 1, [0.802, 0.120], None),
    row(
        TRACKED,
        ("Bunny Dragon", 252_500),
        "kd-tracked",
        1,
        [1.610, 0.210],
        None,
    ),
];

/// All of it.
pub(super) fn their_figures() -> Vec<TheirFigures> {
    let wald = WALD_SCENES.iter().flat_map(|(scene, exact, cells)| {
        let cells = WALD_BUILDERS.iter().zip(cells);
        cells.map(|((builder, threads), (seconds, speed))| {
            row(WALD, *scene, builder, *threads, [*exact, *seconds], Some(*speed))
        })
    });
    GUENTHER.into_iter().chain(wald).chain(HUSSAIN).collect()
}
