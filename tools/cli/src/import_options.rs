use crate::{exit_code::ExitCode, failure::Failure};
use restpose_bake::import::{FrameRange, ImportSettings};
use std::{path::Path, str::FromStr};

/// The import settings that a baked file was made with, by the options in it, so that its source is read as it was then.
///
/// Names and values are those of [`restpose_bake::import::Animation::import_options`].
pub fn import_settings(file: &Path, options: &[(String, String)]) -> Result<ImportSettings, Failure> {
    let default = FrameRange::default();
    Ok(ImportSettings {
        frame_rate: option(file, options, "frame_rate")?,
        frames: FrameRange {
            first: option(file, options, "first_frame")?.unwrap_or(default.first),
            last: option(file, options, "last_frame")?,
            step: option(file, options, "frame_step")?.unwrap_or(default.step),
        },
    })
}

fn option<T: FromStr>(file: &Path, options: &[(String, String)], name: &str) -> Result<Option<T>, Failure> {
    let Some((_, value)) = options.iter().find(|(known, _)| known == name) else {
        return Ok(None);
    };
    value.parse().map(Some).map_err(|_| {
        let message = format!(
            "{}: its option {name} is {value:?}, expected a number; bake it again",
            file.display()
        );
        Failure::at(ExitCode::InvalidInput, file, message)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(options: &[(&str, &str)]) -> Result<ImportSettings, Failure> {
        let text = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        let options: Vec<(String, String)> = options.iter().map(text).collect();
        import_settings(Path::new("x.rpose"), &options)
    }

    #[test]
    fn what_the_options_say_is_read_back() {
        let found = settings(&[
            ("clips", "all"),
            ("frame_rate", "29.97"),
            ("first_frame", "3"),
            ("last_frame", "17"),
            ("frame_step", "2"),
        ]);
        let expected = ImportSettings {
            frame_rate: Some(29.97),
            frames: FrameRange {
                first: 3,
                last: Some(17),
                step: 2,
            },
        };
        assert_eq!(found.expect("numbers"), expected);
        assert_eq!(settings(&[]).expect("nothing to read"), ImportSettings::default());
    }

    #[test]
    fn a_value_that_is_no_number_names_file_and_option() {
        let failure = settings(&[("frame_step", "two")]).expect_err("not a number");
        assert_eq!(failure.code, ExitCode::InvalidInput);
        assert!(
            failure.message.contains("x.rpose: its option frame_step is \"two\""),
            "{failure:?}"
        );
    }
}
