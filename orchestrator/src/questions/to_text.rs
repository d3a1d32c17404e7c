//! Text of answers and decisions for a reader.

use super::Answering;
use bladeoff_answers::ask::{Answer, is_of_group};
use bladeoff_answers::gate::Decision;
use bladeoff_answers::summary::counted;

/// Answers by question, each in a sentence, with its notes below.
#[must_use]
pub fn told(answering: &Answering) -> String {
    let Answering { answers, points, of, .. } = answering;
    let mut text = match (answering.is_design, answering.is_open && points == of) {
        (true, true) => format!(
            "Answers so far, of all {} in the combinations of the last interim analysis; [refine] may add others:\n",
            counted(*of, "point")
        ),
        (true, false) => head("Answers", *points, *of),
        (false, _) => head_of_samples(*points, *of),
    };
    let mut last: Option<&Answer> = None;
    for answer in &answers.answers {
        if last.is_none_or(|last| last.name != answer.name) {
            text.push_str(&format!("\n{}\n", answer.name));
        }
        text.push_str(&format!("  {}\n", answer.sentence));
        answer.lines.iter().for_each(|line| text.push_str(&format!("    {line}\n")));
        // a note that holds for every group is printed once; the number of bad runs belongs to a group
        let is_general = |note: &String| {
            let mut all = answers.answers.iter().filter(|other| other.name == answer.name);
            !is_of_group(note) && all.all(|other| other.notes.contains(note))
        };
        let is_first = last.is_none_or(|last| last.name != answer.name);
        let is_new = |note: &&String| is_first || !is_general(note);
        answer.notes.iter().filter(is_new).for_each(|note| text.push_str(&format!("    {note}\n")));
        last = Some(answer);
    }
    text
}

/// Decisions of gates, each in a sentence.
#[must_use]
pub fn decided(decisions: &[Decision], points: u64, of: u64) -> String {
    let mut text = head("Gates", points, of);
    text.push('\n');
    decisions.iter().for_each(|decision| text.push_str(&format!("{}\n", decision.sentence)));
    text
}

fn head(what: &str, points: u64, of: u64) -> String {
    match points {
        0 => format!(
            "{what}: none yet. Points count in their order, and the first of {} has no complete rows in the tables.\n",
            counted(of, "point")
        ),
        _ if points == of => format!("{what}, of {}:\n", counted(of, "point")),
        _ => format!("{what} so far, of the first {points} of {}:\n", counted(of, "point")),
    }
}

/// Heading for a study in which each sample is a point.
fn head_of_samples(samples: u64, of: u64) -> String {
    match samples {
        0 => format!("Answers: none yet. The tables have no row of {}.\n", counted(of, "sample")),
        _ if samples == of => format!("Answers, of {}:\n", counted(of, "sample")),
        _ => format!("Answers so far, of {samples} of {}:\n", counted(of, "sample")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_says_how_far_it_is() {
        assert_eq!(
            head("Answers", 0, 1000),
            "Answers: none yet. Points count in their order, and the first of 1000 points has no complete rows in the tables.\n"
        );
        assert_eq!(head("Answers", 7, 1000), "Answers so far, of the first 7 of 1000 points:\n");
        assert_eq!(head("Gates", 1, 1), "Gates, of 1 point:\n");
    }
}
