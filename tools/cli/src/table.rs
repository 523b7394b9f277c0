use std::fmt;

/// Rows of text in columns: the first is set to the left, the others to the right where every cell is a number.
pub struct Table<const N: usize> {
    titles: [&'static str; N],
    rows: Vec<[String; N]>,
}

impl<const N: usize> Table<N> {
    /// A table without rows.
    pub fn new(titles: [&'static str; N]) -> Self {
        Self {
            titles,
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn add(&mut self, row: [String; N]) {
        self.rows.push(row);
    }
}

impl<const N: usize> fmt::Display for Table<N> {
    /// Nothing at all where there are no rows.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.rows.is_empty() {
            return Ok(());
        }
        let width = |k: usize| {
            self.rows
                .iter()
                .map(|row| row[k].chars().count())
                .max()
                .unwrap_or(0)
                .max(self.titles[k].len())
        };
        let numbers = |k: usize| self.rows.iter().all(|row| row[k].parse::<f64>().is_ok());
        let columns: [(usize, bool); N] = std::array::from_fn(|k| (width(k), k > 0 && numbers(k)));
        let line = |cells: [&str; N]| {
            let padded: Vec<String> = (0..N)
                .map(|k| match columns[k] {
                    (width, true) => format!("{:>width$}", cells[k]),
                    (width, false) => format!("{:<width$}", cells[k]),
                })
                .collect();
            padded.join("  ").trim_end().to_owned()
        };
        write!(f, "{}", line(self.titles))?;
        self.rows
            .iter()
            .try_for_each(|row| write!(f, "\n{}", line(row.each_ref().map(String::as_str))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_on_the_right_and_words_on_the_left() {
        let mut table = Table::new(["name", "class", "n"]);
        assert_eq!(table.to_string(), "");
        table.add(["über".into(), "rigid".into(), "12".into()]);
        table.add(["x".into(), "a".into(), "3".into()]);
        assert_eq!(table.to_string(), "name  class   n\nüber  rigid  12\nx     a       3");
    }
}
