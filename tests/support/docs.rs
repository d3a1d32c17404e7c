//! The commands of a page of the documentation, run as they are written.

use super::root;
use std::fs;

/// The ```sh blocks of a page that contain these words.
pub fn blocks(page: &str, words: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(page)).expect("the page is there");
    let blocks = text.split("\n```sh\n").skip(1).map(|rest| rest.split("\n```").next().expect("a piece").to_owned());
    blocks.filter(|block| block.contains(words)).collect()
}

/// A block with other paths: each given path must occur in the block, and is replaced.
pub fn with(block: &str, others: &[(&str, &str)]) -> String {
    let mut block = block.to_owned();
    for (written, other) in others {
        assert!(block.contains(written), "{written} is not in: {block}");
        block = block.replace(written, other);
    }
    block
}
