use image::{
    ImageError,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

/// A PNG file of a picture of three bytes per pixel.
pub fn encode_png(rgb: &[u8], width: u32, height: u32) -> Result<Vec<u8>, ImageError> {
    use image::ImageEncoder;
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive).write_image(
        rgb,
        width,
        height,
        image::ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// The picture in a PNG file, three bytes per pixel.
pub fn decode_png(bytes: &[u8]) -> Result<Vec<u8>, ImageError> {
    Ok(image::load_from_memory_with_format(bytes, image::ImageFormat::Png)?
        .into_rgb8()
        .into_raw())
}
