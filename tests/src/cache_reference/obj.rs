/// What an OBJ file says of polygons; free-form curves, normals, texture coordinates and materials are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obj {
    /// `v` lines, in file order.
    pub positions: Vec<[f32; 3]>,
    /// `f` lines, in file order.
    pub faces: Vec<ObjFace>,
}

/// A polygon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjFace {
    /// Name of the last `o` or `g` line before it, whichever came later; `None` where there is none.
    pub group: Option<String>,
    /// Vertices, from 0; at least three.
    pub corners: Vec<usize>,
}

impl ObjFace {
    /// The fan about its first corner.
    pub fn triangles(&self) -> impl Iterator<Item = [usize; 3]> {
        let rest = self.corners[1..].windows(2);
        rest.map(|pair| [self.corners[0], pair[0], pair[1]])
    }
}

impl Obj {
    /// # Panics
    /// When a `v` or `f` line breaks the format or a face names a vertex that is not in the file.
    pub fn parse(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes);
        // A backslash at the end of a line joins it with the next.
        let text = text.replace("\r\n", "\n").replace('\r', "\n").replace("\\\n", " ");
        let mut group = None;
        let mut obj = Self::default();
        for (number, line) in text.split('\n').enumerate() {
            let line = line.split('#').next().unwrap_or("");
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => obj.positions.push(position(words, number)),
                Some("f") => {
                    let corners: Vec<usize> = words.map(|word| vertex(word, obj.positions.len(), number)).collect();
                    assert!(corners.len() >= 3, "line {number}: a face of {} corners", corners.len());
                    obj.faces.push(ObjFace {
                        group: group.clone(),
                        corners,
                    });
                }
                Some("o" | "g") => {
                    let name = words.collect::<Vec<_>>().join(" ");
                    group = Some(if name.is_empty() { "default".to_owned() } else { name });
                }
                _ => {}
            }
        }
        let corners = obj.faces.iter().flat_map(|face| &face.corners);
        for corner in corners {
            assert!(
                *corner < obj.positions.len(),
                "vertex {} is not in the file",
                corner + 1
            );
        }
        obj
    }
}

/// The first three numbers; a weight or a colour may follow.
fn position<'a>(mut words: impl Iterator<Item = &'a str>, number: usize) -> [f32; 3] {
    std::array::from_fn(|axis| {
        let word = words
            .next()
            .unwrap_or_else(|| panic!("line {number}: no number {axis}"));
        word.parse()
            .unwrap_or_else(|error| panic!("line {number}: {word}: {error}"))
    })
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`; numbers count from 1, negative ones back from the vertices so far.
fn vertex(word: &str, so_far: usize, number: usize) -> usize {
    let first = word.split('/').next().unwrap_or("");
    let index: i64 = first
        .parse()
        .unwrap_or_else(|error| panic!("line {number}: {word}: {error}"));
    let from_zero = if index > 0 { index - 1 } else { so_far as i64 + index };
    assert!(index != 0 && from_zero >= 0, "line {number}: vertex {index}");
    from_zero as usize
}
