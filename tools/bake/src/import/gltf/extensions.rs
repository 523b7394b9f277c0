/// Extensions that this reader carries out, or that change nothing which it reads.
const ACCEPTED: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_texture_dds",
    "EXT_mesh_features",
    "EXT_structural_metadata",
];

/// Families whose members concern only how surfaces look.
const ACCEPTED_FAMILIES: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "EXT_materials_",
    "EXT_texture_",
    "EXT_lights_",
    "ADOBE_materials_",
];

/// What to do about extensions that hide geometry from this reader.
const REMEDIES: &[(&str, &str)] = &[
    (
        "KHR_draco_mesh_compression",
        "convert it first, e.g. with `gltf-transform copy in.glb out.glb`",
    ),
    (
        "EXT_meshopt_compression",
        "convert it first, e.g. with `gltfpack -kn -i in.glb -o out.glb`, without -c",
    ),
    (
        "KHR_meshopt_compression",
        "convert it first, e.g. with `gltfpack -kn -i in.glb -o out.glb`, without -c",
    ),
    ("EXT_mesh_gpu_instancing", "export the instances as nodes"),
    (
        "KHR_mesh_primitive_restart",
        "export each strip as a primitive of its own, or as triangles",
    ),
];

/// True when a file that requires this extension can be read.
pub(super) fn is_accepted(name: &str) -> bool {
    ACCEPTED.contains(&name) || ACCEPTED_FAMILIES.iter().any(|family| name.starts_with(family))
}

/// What a user can do about an extension that is not supported.
pub(in crate::import) fn remedy(name: &str) -> Option<&'static str> {
    REMEDIES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, remedy)| *remedy)
}
