use super::schema::{self, Element, Whole};
use crate::import::fault_list::FaultList;

/// A glTF file's JSON whose every element has the right shape; indices are not yet checked.
#[derive(Debug)]
pub(super) struct Document {
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub scene: Option<Whole>,
    pub scenes: Vec<schema::Scene>,
    pub nodes: Vec<schema::Node>,
    pub meshes: Vec<schema::Mesh>,
    pub skins: Vec<schema::Skin>,
    pub animations: Vec<schema::Animation>,
    pub accessors: Vec<schema::Accessor>,
    pub buffer_views: Vec<schema::BufferView>,
    pub buffers: Vec<schema::Buffer>,
}

/// Why JSON is not a document.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum DocumentError {
    /// It is something else, described.
    Foreign(String),
    /// It does not fit; the fault list says where.
    Broken,
}

/// Reads the JSON. Every element that does not fit is reported.
pub(super) fn parse(json: &[u8], faults: &mut FaultList) -> Result<Document, DocumentError> {
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let parsed: Result<schema::Root, _> = serde_path_to_error::deserialize(&mut deserializer);
    let root = match parsed {
        Ok(root) => root,
        Err(error) => {
            if let Ok(schema::Head { asset: Some(asset) }) = serde_json::from_slice(json) {
                check_version(&asset)?;
            }
            faults.error(schema::json_pointer(error.path()), error.inner().to_string());
            return Err(DocumentError::Broken);
        }
    };
    check_version(&root.asset)?;
    if let Err(error) = deserializer.end() {
        faults.warn("", format!("text behind the JSON object is ignored: {error}"));
    }
    let document = Document {
        extensions_used: root.extensions_used,
        extensions_required: root.extensions_required,
        scene: root.scene,
        scenes: fitting("scenes", root.scenes, faults),
        nodes: fitting("nodes", root.nodes, faults),
        meshes: fitting("meshes", root.meshes, faults),
        skins: fitting("skins", root.skins, faults),
        animations: fitting("animations", root.animations, faults),
        accessors: fitting("accessors", root.accessors, faults),
        buffer_views: fitting("bufferViews", root.buffer_views, faults),
        buffers: fitting("buffers", root.buffers, faults),
    };
    // Elements that do not fit are left out, so the numbers of those behind them would be wrong from here on.
    if faults.has_errors() {
        Err(DocumentError::Broken)
    } else {
        Ok(document)
    }
}

fn check_version(asset: &schema::Asset) -> Result<(), DocumentError> {
    let foreign = |what: &str, version: &str| Err(DocumentError::Foreign(format!("{what} {version}")));
    if asset.version.split('.').next() != Some("2") {
        return foreign("the file is glTF", &asset.version);
    }
    match asset.min_version.as_deref() {
        None | Some("2.0") => Ok(()),
        Some(version) => foreign("the file needs a reader of glTF", version),
    }
}

fn fitting<T>(section: &str, elements: Vec<Element<T>>, faults: &mut FaultList) -> Vec<T> {
    let mut out = Vec::with_capacity(elements.len());
    for (number, element) in elements.into_iter().enumerate() {
        match element {
            Element::Good(element) => out.push(element),
            Element::Bad(pointer, message) => faults.error(format!("/{section}/{number}{pointer}"), message),
        }
    }
    out
}
