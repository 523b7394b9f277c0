/// How the program ends. Scripts may rely on these numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ExitCode {
    /// Everything asked for was done.
    Ok = 0,
    /// The command line cannot be understood or contradicts itself or the files it names.
    CommandLine = 1,
    /// A file or folder cannot be read or written.
    Io = 2,
    /// A source or a `.rpose` file breaks its format.
    InvalidInput = 3,
    /// Something inside the program failed.
    Internal = 4,
    /// The input is sound but needs something that this version does not have.
    Unsupported = 5,
    /// A verification found a missed or a wrong hit.
    VerificationFailed = 7,
}

impl ExitCode {
    /// All codes, in the order of their numbers.
    pub const ALL: [Self; 7] = [
        Self::Ok,
        Self::CommandLine,
        Self::Io,
        Self::InvalidInput,
        Self::Internal,
        Self::Unsupported,
        Self::VerificationFailed,
    ];

    /// The number that the shell sees.
    pub fn number(self) -> u8 {
        self as u8
    }

    /// The name that JSON shows.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::CommandLine => "command_line",
            Self::Io => "io",
            Self::InvalidInput => "invalid_input",
            Self::Internal => "internal",
            Self::Unsupported => "unsupported",
            Self::VerificationFailed => "verification_failed",
        }
    }

    /// What it means, for `--help`.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Ok => "done",
            Self::CommandLine => "the command line is wrong, or does not fit the files it names",
            Self::Io => "a file or folder cannot be read or written",
            Self::InvalidInput => "a source or a .rpose file breaks its format",
            Self::Internal => "something inside the program failed",
            Self::Unsupported => "the input needs an extension or a motion class that this version does not have",
            Self::VerificationFailed => "verification found a missed or a wrong hit",
        }
    }

    /// The table that ends `--help`.
    pub fn table() -> String {
        let rows = Self::ALL.map(|code| format!("  {}  {}", code.number(), code.meaning()));
        format!("Exit codes:\n{}", rows.join("\n"))
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code.number())
    }
}
