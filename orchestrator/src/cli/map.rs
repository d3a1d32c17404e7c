//! `bladeoff map`: a column, or the probability of an event, over two parameters, as a picture or a page.

use super::answer::asked_of;
use super::error::CliError;
use super::exit::Exit;
use super::gate::name;
use super::json::pretty;
use super::output::{print_json, remark, tell};
use super::place::default_directory;
use super::plot::replacing;
use crate::questions::{answer, question_of, told};
use crate::run::directory::{MANIFEST, RESULTS};
use bladeoff_answers::ask::{Ask, Question, QuestionDef};
use bladeoff_answers::figures;
use bladeoff_answers::map::Map;
use bladeoff_answers::page::{Block, Page, Section, map_figures};
use bladeoff_study::Samples;
use bladeoff_system::files::write_whole;
use bladeoff_system::shown;
use std::path::{Path, PathBuf};

/// Draw a column, or the probability of an event, over two parameters of a study
///
/// Colours show the column or the probability, lines its levels, orange lines the boundaries of rub regimes. Each
/// combination of values of the other `[[vary]]` axes has a panel. If the contact detection varies, the difference
/// between its values at the same inputs is drawn as well.
///
/// If both parameters vary over given values, each combination is a cell. It shows the median and the 95 % value of its
/// runs (points of the `[design]`, release angles), or the share of runs in which the event happened. Otherwise samples
/// are scattered and smoothed, and a second picture has the half width of the interval. Areas without samples stay empty.
/// Cells with failed or invalid runs are marked and split: lower left counts these runs as harmless, upper right as
/// harmful.
///
/// Without --x, --y and --of the maps of the study file are drawn.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff map runs/gap-friction-map \\
    --x contact.gap --y contact.friction \\
    --of max_bearing_load_N --out map.svg
  bladeoff map runs/gap-friction-map \\
    --x contact.gap --y contact.friction \\
    --of \"P(max_bearing_load_N > 1.2 MN)\" --out map.png
  bladeoff map runs/gap-friction-map \\
    --question loads --out map.png")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if it contains a study, otherwise the newest one
    /// below runs/]
    directory: Option<PathBuf>,

    /// Parameter of the horizontal axis: its path, its short name or its column
    #[arg(long, value_name = "PATH", requires = "y", requires = "of")]
    x: Option<String>,

    /// Parameter of the vertical axis
    #[arg(long, value_name = "PATH", requires = "x", requires = "of")]
    y: Option<String>,

    /// A column of the table, or "P(CONDITION)"
    #[arg(long, value_name = "COLUMN|P(EXPR)", requires = "x", requires = "y")]
    of: Option<String>,

    /// Name of a map of the study file
    #[arg(long, value_name = "NAME", conflicts_with_all = ["x", "y", "of", "confidence"])]
    question: Option<String>,

    /// Confidence of the limits
    #[arg(long, value_name = "NUMBER", requires = "x", default_value_t = 0.95)]
    confidence: f64,

    /// File: .svg, .png, or .html with zoom and the numbers of each cell; an existing file is replaced
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// Print JSON: the answer with its cells, as `answer --json` prints it, and the path of the file
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    refuse_other_formats(&args.out)?;
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    let (samples, file, asked) = asked_of(&directory, None)?;
    let question = match (&args.x, &args.y, &args.of) {
        (Some(x), Some(y), Some(of)) => by_words(&samples, args, [x, y], of)?,
        _ => of_study(&asked.questions, args.question.as_deref(), &file)?,
    };
    let answering = answer(&directory, &samples, std::slice::from_ref(&question))?;
    if !answering.is_known {
        let table = shown(directory.join(RESULTS));
        remark(&format!("warning: {table} cannot be verified: {MANIFEST} has no checksum of it"));
    }
    let maps: Vec<Map> = answering.answers.answers.iter().filter_map(|answer| answer.map.as_deref().cloned()).collect();
    if maps.is_empty() {
        tell(&told(&answering))?;
        return Err(CliError::Argument {
            argument: format!("--out {}", shown(&args.out)),
            message: "nothing is drawn: no run is finished, or a column is missing".to_owned(),
            allowed: None,
        });
    }
    let is_worded = args.question.is_none() && args.x.is_some();
    let title = format!("{}: {}", name(&directory, &samples), if is_worded { &maps[0].of } else { &question.name });
    if args.out.extension().is_some_and(|extension| extension == "html") {
        let page = page(&title, &question.name, &maps, &told(&answering));
        replacing(&args.out, || write_whole(&args.out, page.html().as_bytes()))?;
    } else {
        let figure = figures::maps(&title, &maps);
        replacing(&args.out, || figure.write(&args.out))?;
    }
    if args.json {
        let mut answers = serde_json::to_value(&answering.answers).map_err(|error| CliError::stdout(error.into()))?;
        answers["file"] = shown(&args.out).into();
        print_json(&pretty(&answers))?;
    } else {
        tell(&format!("{}\nMap: {}\n", told(&answering), shown(&args.out)))?;
    }
    Ok(Exit::Ok)
}

/// The maps as a self-contained page with zoom and the numbers of each cell.
fn page(title: &str, name: &str, maps: &[Map], said: &str) -> Page {
    let mut blocks = vec![Block::Verbatim(said.to_owned())];
    blocks.extend(map_figures(name, maps, maps.len()).into_iter().map(Block::from));
    let section = Section { id: "maps", heading: "Maps".to_owned(), blocks };
    Page { title: title.to_owned(), lead: Vec::new(), sections: vec![section], reload: None }
}

fn refuse_other_formats(out: &Path) -> Result<(), CliError> {
    let extension = out.extension().and_then(|extension| extension.to_str());
    if matches!(extension, Some("svg" | "png" | "html")) && !out.is_dir() {
        return Ok(());
    }
    Err(CliError::Argument {
        argument: format!("--out {}", shown(out)),
        message: "a map is one file; its extension selects the format".to_owned(),
        allowed: Some(".svg, .png or .html".to_owned()),
    })
}

/// Map defined on the command line.
fn by_words(samples: &Samples, args: &Args, [x, y]: [&String; 2], of: &str) -> Result<Question, CliError> {
    let def = QuestionDef {
        name: "map".to_owned(),
        map: Some([x.clone(), y.clone()]),
        of: Some(of.to_owned()),
        confidence: Some(args.confidence),
        ..QuestionDef::default()
    };
    question_of(samples, &def)?.map_err(|problems| {
        let mut options: Vec<String> = Vec::new();
        for problem in &problems {
            let option = match problem.key {
                "of" => format!("--of {of}"),
                "confidence" => format!("--confidence {}", args.confidence),
                _ => format!("--x {x} --y {y}"),
            };
            if !options.contains(&option) {
                options.push(option);
            }
        }
        let messages: Vec<&str> = problems.iter().map(|problem| problem.message.as_str()).collect();
        let allowed: Vec<&str> = problems.iter().filter_map(|problem| problem.allowed.as_deref()).collect();
        let allowed = Some(allowed.join("; ")).filter(|allowed| !allowed.is_empty());
        CliError::Argument { argument: options.join(" "), message: messages.join("; "), allowed }
    })
}

/// Map of the study file.
fn of_study(questions: &[Question], name: Option<&str>, file: &Path) -> Result<Question, CliError> {
    let maps = || questions.iter().filter(|question| matches!(question.ask, Ask::Map(_)));
    let names: Vec<&str> = maps().map(|question| question.name.as_str()).collect();
    let wrong = |argument: String, message: String| {
        let allowed = if names.is_empty() {
            "--x PATH --y PATH --of COLUMN, or --of \"P(CONDITION)\"".to_owned()
        } else {
            format!("--question {}", names.join(", --question "))
        };
        Err(CliError::Argument { argument, message, allowed: Some(allowed) })
    };
    match (name, maps().count()) {
        (Some(name), _) => match maps().find(|question| question.name == name) {
            Some(question) => Ok(question.clone()),
            None => wrong(format!("--question {name}"), format!("{} asks for no map of this name", shown(file))),
        },
        (None, 1) => Ok(maps().next().expect("one was counted").clone()),
        (None, 0) => wrong("map".to_owned(), format!("{} asks for no map", shown(file))),
        (None, count) => wrong("map".to_owned(), format!("{} asks for {count} maps; select one of them", shown(file))),
    }
}
