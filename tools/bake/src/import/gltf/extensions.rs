/// Extensions that this reader carries out, or that change nothing which it reads.
const ACCEPTED: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_texture_basisu",
    "KHR_lights_punctual",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_lights_image_based",
    "EXT_lights_ies",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
    "EXT_mesh_features",
    "EXT_structural_metadata",
];

/// Families whose members concern only how surfaces look.
const ACCEPTED_FAMILIES: &[&str] = &["KHR_materials_", "EXT_materials_", "ADOBE_materials_"];

/// Where on an object stands data that only an extension can unpack, and with which program to unpack it beforehand.
const COMPRESSIONS: &[(&str, &str)] = &[
    (
        "KHR_draco_mesh_compression",
        "convert it first: `gltf-transform copy in.glb out.glb` writes it without Draco",
    ),
    (
        "EXT_meshopt_compression",
        "convert it first: `gltf-transform copy in.glb out.glb`, or run gltfpack without -c, -cc or -ce",
    ),
    (
        "KHR_meshopt_compression",
        "convert it first: `gltf-transform copy in.glb out.glb`, or run gltfpack without -c, -cc or -ce",
    ),
    ("EXT_mesh_gpu_instancing", "export the instances as nodes"),
];

/// True when a file that requires this extension can be read.
pub(super) fn is_accepted(name: &str) -> bool {
    ACCEPTED.contains(&name)
        || ACCEPTED_FAMILIES
            .iter()
            .any(|family| name.starts_with(family))
}

/// What a user can do about an extension that is not supported.
pub(in crate::import) fn remedy(name: &str) -> Option<&'static str> {
    COMPRESSIONS
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, remedy)| *remedy)
}
