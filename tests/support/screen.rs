//! A simulated terminal, for the unit tests of the progress bar and for those of the program on a terminal.

/// Screen of a terminal with this number of columns after printing `text`: letters, line feeds, and the commands that are used. A letter beyond
/// the right margin begins a new row.
pub fn screen(text: &str, columns: usize) -> Vec<String> {
    let (mut rows, mut row, mut column) = (vec![Vec::new()], 0_usize, 0_usize);
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        rest = &rest[letter.len_utf8()..];
        match letter {
            '\r' => column = 0,
            '\n' => row += 1,
            '\x1b' => {
                // output read while it is written may end anywhere
                let Some(end) = rest.find(|c: char| c.is_ascii_alphabetic()) else { break };
                let (command, after) = rest.split_at(end + 1);
                rest = after;
                match command {
                    "[K" => rows[row].truncate(column),
                    "[A" => row = row.saturating_sub(1),
                    "[J" => {
                        rows[row].truncate(column);
                        rows.truncate(row + 1);
                    }
                    _ => panic!("a command that this terminal does not know: {command:?}"),
                }
            }
            letter => {
                if column == columns {
                    (row, column) = (row + 1, 0);
                    rows.resize(rows.len().max(row + 1), Vec::new());
                }
                let shown: &mut Vec<char> = &mut rows[row];
                shown.resize(shown.len().max(column + 1), ' ');
                shown[column] = letter;
                column += 1;
            }
        }
        rows.resize(rows.len().max(row + 1), Vec::new());
    }
    rows.into_iter().map(String::from_iter).collect()
}
