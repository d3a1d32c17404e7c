//! Blocks and sections of a page.

use super::figure::Figure;
use super::table::Table;

/// An HTML page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// Title.
    pub title: String,
    /// Blocks below the title, before the contents.
    pub lead: Vec<Block>,
    /// Sections in order.
    pub sections: Vec<Section>,
    /// Interval \[s\] at which a browser reloads the page; `None`: no reload.
    pub reload: Option<u64>,
}

/// A section of a page, listed in its contents.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Target of links: `[a-z-]+`, unique in a page.
    pub id: &'static str,
    /// Heading text.
    pub heading: String,
    /// Blocks in order.
    pub blocks: Vec<Block>,
}

/// A block of a page. Its texts may come from any file and are escaped.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A heading within a section.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A remark in a less prominent style.
    Note(String),
    /// The main result in one line.
    Verdict(String),
    /// Essential reservation: an incomplete study, failed runs.
    Warning(String),
    /// Sentences, one per line.
    List(Vec<String>),
    /// Rows and columns.
    Table(Table),
    /// Preformatted text, such as a command or a file.
    Verbatim(String),
    /// A picture.
    Figure(Box<Figure>),
    /// A summary and the blocks shown when it is opened, and in print.
    Details(String, Vec<Block>),
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figure(Box::new(figure))
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}
