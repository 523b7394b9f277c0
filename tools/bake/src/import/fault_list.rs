use super::{Fault, Severity};
use std::collections::BTreeSet;

/// No more than this many faults of one severity are listed; a last one counts the rest. A broken exporter repeats one
/// mistake at every node, and nobody reads further.
const MAX_LISTED: usize = 1000;

/// Faults in the order in which they were found, each once.
#[derive(Debug, Default)]
pub(super) struct FaultList {
    faults: Vec<Fault>,
    seen: BTreeSet<(Severity, String, String)>,
    errors: usize,
    warnings: usize,
}

impl FaultList {
    /// Adds an error.
    pub fn error(&mut self, path: impl Into<String>, message: impl Into<String>) {
        self.push(Fault {
            severity: Severity::Error,
            path: path.into(),
            message: message.into(),
        });
    }

    /// Adds a warning.
    pub fn warn(&mut self, path: impl Into<String>, message: impl Into<String>) {
        self.push(Fault {
            severity: Severity::Warning,
            path: path.into(),
            message: message.into(),
        });
    }

    /// Adds a fault.
    pub fn push(&mut self, fault: Fault) {
        let count = match fault.severity {
            Severity::Error => &mut self.errors,
            Severity::Warning => &mut self.warnings,
        };
        if *count >= MAX_LISTED {
            *count += 1;
            return;
        }
        if self
            .seen
            .insert((fault.severity, fault.path.clone(), fault.message.clone()))
        {
            *count += 1;
            self.faults.push(fault);
        }
    }

    /// The value, or nothing and one more fault.
    pub fn keep<T>(&mut self, result: Result<T, Fault>) -> Option<T> {
        result.map_err(|fault| self.push(fault)).ok()
    }

    /// True when an error has been added.
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// All faults, errors first.
    pub fn into_faults(mut self) -> Vec<Fault> {
        self.faults.sort_by_key(|fault| std::cmp::Reverse(fault.severity));
        for (severity, count) in [(Severity::Error, self.errors), (Severity::Warning, self.warnings)] {
            if count > MAX_LISTED {
                let message = format!("{} further faults of this severity are not listed", count - MAX_LISTED);
                self.faults.push(Fault {
                    severity,
                    path: String::new(),
                    message,
                });
            }
        }
        self.faults
    }
}

impl Fault {
    /// An error at a place.
    pub(super) fn error(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            path: path.into(),
            message: message.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_each_fault_once_and_errors_first() {
        let mut list = FaultList::default();
        list.warn("/a", "w");
        list.error("/b", "e");
        list.error("/b", "e");
        assert!(list.has_errors());
        let faults = list.into_faults();
        assert_eq!(faults.iter().map(|f| f.path.as_str()).collect::<Vec<_>>(), ["/b", "/a"]);
    }

    #[test]
    fn counts_what_it_does_not_list() {
        let mut list = FaultList::default();
        for k in 0..MAX_LISTED + 7 {
            list.error(format!("/nodes/{k}"), "e");
        }
        let faults = list.into_faults();
        assert_eq!(faults.len(), MAX_LISTED + 1);
        assert!(faults[MAX_LISTED].message.starts_with("7 further"));
    }
}
