/// A row of a table of `N` columns.
pub trait TextRow<const N: usize> {
    /// What the table shows.
    const TITLE: &'static str;
    /// What the columns are.
    const LEGEND: &'static str;
    /// Titles of the columns.
    const COLUMNS: [&'static str; N];

    /// The row as text, short.
    fn cells(&self) -> [String; N];
}
