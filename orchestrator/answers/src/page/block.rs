//! Blocks and sections of a page.

use super::figure::Figure;
use super::table::Table;

/// A page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// Under it, before the contents.
    pub lead: Vec<Block>,
    /// In order.
    pub sections: Vec<Section>,
    /// Seconds after which a browser loads the page again; `None`: it stays.
    pub reload: Option<u64>,
}

/// A part of a page, with a place in its contents.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// What links lead to: `[a-z-]+`, once in a page.
    pub id: &'static str,
    /// In words.
    pub heading: String,
    /// In order.
    pub blocks: Vec<Block>,
}

/// Something in a page. All of it is text from anywhere.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A heading within a section.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A remark, quieter.
    Note(String),
    /// The one line that a hurried reader reads.
    Verdict(String),
    /// What has to be seen first: an incomplete study, runs that failed.
    Warning(String),
    /// Sentences, one below the other.
    List(Vec<String>),
    /// Rows and columns.
    Table(Table),
    /// Text as it is, such as a command or a file.
    Verbatim(String),
    /// A picture.
    Figure(Box<Figure>),
    /// Shown when it is asked for, and in print; a summary and what it opens.
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
