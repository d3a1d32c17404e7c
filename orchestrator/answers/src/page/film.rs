//! The animated orbit of a history: one HTML file with a slider, without network; printed and without scripts the instant of the first contact.
//!
//! ```text
//! history --instants: evenly spaced, and those of the marks--> frames --> integers in a drawing of 8000 units --> drawing, JSON, film.js
//! ```
//! The clearance line is the one of [`crate::figures::orbits`]. Frames, nodes and points of the path are limited, so that a page is below 2 MB
//! for any history; the page prints how many of the instants it shows.
//! Verified by `an_animation_has_the_instants_and_marks_of_its_history`.

use super::escape::{html, json};
use super::figure::short;
use crate::drawing::{Anchor, Axis, Frame, Ruling, Svg, shown};
use crate::figures::{Contact, Ring, Scale, clearance, critical_passages, fixed, last_turn, reach_of, ring_of};
use crate::history::{History, Series};
use serde_json::{Value, json as value};
use std::fmt::Write;

const SCRIPT: &str = include_str!("film.js");
const STYLE: &str = include_str!("film.css");
/// SHA-256 of the script in the page's policy; a test compares it.
const HASH: &str = "Z+wGeuO5Vxl391qUaoyRnfwtk6OfMTG/OsBkfOTR3gc=";

/// Largest numbers of frames, of node radii in all frames, and of points of the rotor's path.
const FRAMES: usize = 600;
const RADII: usize = 120_000;
const POINTS: usize = 60_000;
/// Largest number of marks of critical speeds.
const MOST_CRITICAL: usize = 6;
/// Distance from the middle of the drawing to its frame, and margin around the frame, in drawing units.
const HALF: f64 = 4000.0;
const ROOM: f64 = 900.0;
/// Strip of the clearance over time: width, height, left and lower edge of its frame.
const STRIP: [f64; 4] = [600.0, 160.0, 62.0, 114.0];

/// A marked instant.
struct Mark {
    frame: usize,
    label: String,
}

struct Film<'a> {
    history: &'a History,
    x: &'a Series,
    y: &'a Series,
    gap: Option<f64>,
    clearance: Option<&'a Series>,
    /// Indices of the shown records, ascending.
    frames: Vec<usize>,
    marks: Vec<Mark>,
    length: Scale,
    /// Drawing units per metre.
    unit: f64,
}

/// The page of a history at one contact; `title`: file and machine. `None` without finite places of the rotor at this contact.
#[must_use]
pub fn animation(history: &History, title: &str, contact: &Contact) -> Option<String> {
    let [x, y] = ["rotor_x_m", "rotor_y_m"].map(|field| contact.channel(history, field));
    let (x, y) = (x?, y?);
    let is_place = |at: &usize| x.values[*at].is_finite() && y.values[*at].is_finite();
    let records: Vec<usize> = (0..history.time.len()).filter(is_place).collect();
    let (first, last) = (*records.first()?, *records.last()?);
    let gap = contact.gap(history);
    let reach = reach_of(history, contact, records.iter().map(|at| x.values[*at].hypot(y.values[*at])));
    let length = Scale::of("m", reach);
    let radial = contact.radial(history);
    let most = FRAMES.min((RADII / radial.len().max(1)).max(2)).min(records.len());
    let mut frames: Vec<usize> = (0..most).map(|k| records[k * (records.len() - 1) / (most - 1).max(1)]).collect();
    let times = |at: f64| history.time.partition_point(|time| *time < at).clamp(first, last);
    let mut wanted: Vec<(usize, String)> = Vec::new();
    if let Some(at) = contact.first_contact(history) {
        wanted.push((times(at), format!("first contact, {} s", shown(at))));
    }
    for (at, speed) in critical_passages(history).into_iter().take(MOST_CRITICAL) {
        let rpm = shown((speed * 30.0 / std::f64::consts::PI).round());
        wanted.push((times(at), format!("critical speed {rpm} rpm, {} s", shown(at))));
    }
    wanted.retain(|(at, _)| is_place(at));
    wanted.sort();
    frames.extend(wanted.iter().map(|(at, _)| *at));
    frames.sort_unstable();
    frames.dedup();
    let frame = |at: usize| frames.partition_point(|other| *other < at);
    let marks = wanted.into_iter().map(|(at, label)| Mark { frame: frame(at), label }).collect();
    let clearance = contact.channel(history, "gap_m");
    let film = Film { history, x, y, gap, clearance, frames, marks, unit: HALF / reach, length };
    Some(film.page(title, contact, &radial))
}

impl Film<'_> {
    fn page(&self, title: &str, contact: &Contact, radial: &[&Series]) -> String {
        let first = self.marks.iter().find(|mark| mark.label.starts_with("first contact")).map(|mark| mark.frame);
        let first = first.unwrap_or(self.frames.len() - 1);
        let path = self.path();
        let force = contact.channel(self.history, "filtered_force_N");
        let largest =
            force.map_or(0.0, |force| force.values.iter().filter(|f| f.is_finite()).fold(0.0_f64, |a, b| a.max(*b)));
        let force_scale = Scale::of("N", largest);
        let of = |series: Option<&Series>, factor: f64| -> Vec<Value> {
            let number =
                |at: &usize| series.map(|series| series.values[*at] * factor).filter(|value| value.is_finite());
            self.frames.iter().map(|at| value!(number(at).map(short))).collect()
        };
        let speed = self.history.channel("rotor.speed_rad_s");
        let times: Vec<Value> = self.frames.iter().map(|at| value!(short(self.history.time[*at]))).collect();
        let clearances = of(self.clearance, self.length.factor);
        let forces = of(force, force_scale.factor);
        let angle = contact.channel(self.history, "angle_rad");
        let rings: Vec<Option<Vec<i64>>> = self.frames.iter().map(|at| self.radii(radial, *at)).collect();
        let strip = self.strip(first);
        let data = value!({
            "first": first, "time": times,
            "speed": of(speed, 30.0 / std::f64::consts::PI), "clearance": clearances,
            "force": forces, "angle": of(angle, 180.0 / std::f64::consts::PI),
            "ring": if radial.is_empty() { Vec::new() } else { rings.clone() },
            "x": path.x, "y": path.y, "from": path.from, "to": path.to,
            "digits": {
                "time": digits(&times, 1), "speed": 1, "clearance": digits(&clearances, 0), "force": digits(&forces, 0),
            },
            "strip": [STRIP[2], STRIP[0] - 8.0], "now": format!("MX,8V{}", STRIP[3]),
        });
        let mut body = format!("<header>\n<h1>{}</h1>\n</header>\n<main id=\"content\">\n", html(title));
        let mut put = |text: std::fmt::Arguments<'_>| body.write_fmt(text).expect("writing to a String cannot fail");
        put(format_args!("<figure>\n<ul class=\"key\">\n"));
        let ring = ring_of(self.history, contact);
        let keys = [
            (true, "c0", "rotor centre, last turn"),
            (ring != Ring::Unknown, "quiet", "gap at rest"),
            (ring == Ring::Deformed, "c1", "clearance of the deformed ring"),
            (angle.is_some(), "c2", "direction of the closest place"),
        ];
        for (_, colour, text) in keys.into_iter().filter(|key| key.0) {
            put(format_args!("<li class=\"{colour}\"><span></span>{text}</li>\n"));
        }
        put(format_args!("</ul>\n{}<ul class=\"read\">\n", self.drawing(first, &rings, &path, angle)));
        let reads = [
            (true, "time", "t", "s"),
            (speed.is_some(), "speed", "speed", "rpm"),
            (self.clearance.is_some(), "clearance", "smallest clearance", self.length.unit.as_str()),
            (force.is_some(), "force", "contact force, 1 ms mean", force_scale.unit.as_str()),
        ];
        for (_, id, text, unit) in reads.into_iter().filter(|read| read.0) {
            let places = data["digits"][id].as_u64().unwrap_or(3) as usize;
            let now = data[id][first].as_f64().map_or("–".to_owned(), |now| fixed(now, places));
            put(format_args!("<li>{text} <b id=\"{id}\">{}</b> {}</li>\n", html(&now), html(unit)));
        }
        let last = self.frames.len() - 1;
        put(format_args!(
            "</ul>\n<div id=\"controls\" hidden>\n<input id=\"slider\" type=\"range\" min=\"0\" max=\"{last}\" value=\"{first}\" aria-label=\"Instant\">\n\
             <button id=\"play\" type=\"button\">Play</button>\n<label>Pace <select id=\"pace\">"
        ));
        // 25 frames per second
        let span = self.history.time[self.frames[last]] - self.history.time[self.frames[0]];
        for (pace, selected) in [("0.1", ""), ("0.25", ""), ("1", " selected"), ("4", "")] {
            let run = shown(pace.parse::<f64>().unwrap_or(1.0) * 25.0 * span / last.max(1) as f64);
            put(format_args!("<option value=\"{pace}\"{selected}>{run} s of the run in 1 s</option>"));
        }
        put(format_args!("</select></label>\n</div>\n{strip}"));
        put(format_args!("<ol class=\"marks\">\n"));
        for mark in &self.marks {
            put(format_args!(
                "<li><button type=\"button\" data-frame=\"{}\">{}</button></li>\n",
                mark.frame,
                html(&mark.label)
            ));
        }
        put(format_args!("</ol>\n<figcaption>{}</figcaption>\n</figure>\n</main>\n", html(&self.caption(&path, ring))));
        let page_style = super::shell::STYLE;
        let policy = format!(
            "default-src 'none'; script-src 'sha256-{HASH}'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
        );
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"referrer\" content=\"no-referrer\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"bladeoff\">\n<title>{}</title>\n<style>\n{page_style}{STYLE}</style>\n</head>\n<body>\n{body}\
             <script type=\"application/json\" id=\"frames\">{}</script>\n<script>{SCRIPT}</script>\n</body>\n</html>\n",
            html(title),
            json(&data)
        )
    }

    fn place(&self, metres: f64) -> i64 {
        (metres * self.unit).round() as i64
    }

    /// Radii of the clearance at the nodes; `None` if one is not finite, or the gap is unknown.
    fn radii(&self, radial: &[&Series], at: usize) -> Option<Vec<i64>> {
        let gap = self.gap?;
        let radii = radial.iter().map(|node| Some(gap + node.values[at]).filter(|radius| radius.is_finite()));
        radii.map(|radius| radius.map(|radius| self.place(radius).clamp(-40_000, 40_000))).collect()
    }

    /// The rotor's path, and its part in each frame.
    fn path(&self) -> Path {
        let turns: Vec<std::ops::Range<usize>> =
            self.frames.iter().map(|at| last_turn(self.history, self.history.time[*at])).collect();
        let is_place = |at: &usize| self.x.values[*at].is_finite() && self.y.values[*at].is_finite();
        let (first, last) = (turns.first().map_or(0, |turn| turn.start), self.frames.last().map_or(0, |at| at + 1));
        let every = (last - first).div_ceil(POINTS).max(1);
        // each frame ends at its own instant
        let mut kept: Vec<usize> =
            (first..last).step_by(every).chain(self.frames.iter().copied()).filter(is_place).collect();
        kept.sort_unstable();
        kept.dedup();
        let number = |at: usize| kept.partition_point(|other| *other < at);
        let to: Vec<usize> = self.frames.iter().map(|at| number(*at) + 1).collect();
        let from = turns.iter().zip(&to).map(|(turn, to)| number(turn.start).min(to - 1)).collect();
        let along = |series: &Series| kept.iter().map(|at| self.place(series.values[*at])).collect();
        Path { x: along(self.x), y: along(self.y), from, to, every }
    }

    fn caption(&self, path: &Path, ring: Ring) -> String {
        let (records, frames) = (self.history.time.len(), self.frames.len());
        let mut text = format!("{frames} of {records} instants are shown");
        if path.every > 1 {
            text += &format!(", and one of {} points of the orbit", path.every);
        }
        if frames < records {
            text += "; select a shorter span with --from and --to to see more of them";
        }
        text += ". The strip has the smallest clearance between two shown instants.";
        text += match ring {
            Ring::Deformed => "",
            Ring::AtRest => " The channels of the ring were not recorded: the gap is the one at rest.",
            Ring::Unknown => " The file has no geometry: no gap is drawn.",
        };
        text
    }

    fn drawing(&self, first: usize, rings: &[Option<Vec<i64>>], path: &Path, angle: Option<&Series>) -> String {
        let (low, size) = (-HALF - ROOM, 2.0 * HALF + 1.2 * ROOM);
        let mut out = format!(
            "<svg class=\"film orbit\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{low} {} {size} {size}\" role=\"img\" aria-label=\"rotor centre within the clearance\">\n",
            -HALF - 0.2 * ROOM
        );
        let mut put = |text: std::fmt::Arguments<'_>| out.write_fmt(text).expect("writing to a String cannot fail");
        let reach = HALF / self.unit * self.length.factor;
        let axis = Axis::between("", (-reach, reach));
        let ticks = axis.ticks();
        for (value, text) in ticks.iter().step_by(if ticks.len() > 7 { 2 } else { 1 }) {
            let at = value / reach * HALF;
            put(format_args!("<path class=\"grid\" d=\"M{at:.0},{HALF}V{}M{},{:.0}H{HALF}\"/>\n", -HALF, -HALF, -at));
            put(format_args!("<text x=\"{at:.0}\" y=\"{}\" text-anchor=\"middle\">{text}</text>\n", HALF + 300.0));
            put(format_args!(
                "<text x=\"{}\" y=\"{:.0}\" text-anchor=\"end\">{text}</text>\n",
                -HALF - 80.0,
                80.0 - at
            ));
        }
        let unit = html(&self.length.unit);
        put(format_args!("<text x=\"0\" y=\"{}\" text-anchor=\"middle\">x [{unit}]</text>\n", HALF + 620.0));
        put(format_args!(
            "<text transform=\"translate({} 0) rotate(-90)\" text-anchor=\"middle\">y [{unit}]</text>\n",
            low + 230.0
        ));
        put(format_args!(
            "<rect class=\"frame\" x=\"{0}\" y=\"{0}\" width=\"{1}\" height=\"{1}\"/>\n",
            -HALF,
            2.0 * HALF
        ));
        // clip at the frame
        put(format_args!(
            "<svg x=\"{0}\" y=\"{0}\" width=\"{1}\" height=\"{1}\" viewBox=\"{0} {0} {1} {1}\">\n",
            -HALF,
            2.0 * HALF
        ));
        if let Some(gap) = self.gap {
            put(format_args!("<circle class=\"gap\" r=\"{}\"/>\n", self.place(gap)));
        }
        let nodes = rings[first].as_ref().map(|radii| radii.iter().map(|radius| *radius as f64).collect::<Vec<_>>());
        let line = nodes.and_then(|nodes| clearance(&nodes, 0.0)).unwrap_or_default();
        let line: Vec<String> = line.iter().map(|(x, y)| format!("{:.0},{:.0}", x, -y)).collect();
        let line = if line.is_empty() { String::new() } else { format!("M{}Z", line.join("L")) };
        put(format_args!("<path class=\"ring-line\" id=\"ring\" d=\"{line}\"/>\n"));
        if let Some(angle) = angle.map(|angle| angle.values[self.frames[first]]).filter(|angle| angle.is_finite()) {
            let (tip, foot) = (HALF - 330.0, HALF - 60.0);
            put(format_args!(
                "<path class=\"closest\" id=\"closest\" d=\"M{tip},0L{foot},-130V130Z\" transform=\"rotate({:.1})\"/>\n",
                -angle.to_degrees()
            ));
        }
        let trail: Vec<String> =
            (path.from[first]..path.to[first]).map(|at| format!("{},{}", path.x[at], -path.y[at])).collect();
        put(format_args!("<polyline class=\"trail\" id=\"trail\" points=\"{}\"/>\n", trail.join(" ")));
        let end = path.to[first] - 1;
        put(format_args!(
            "<circle class=\"rotor\" id=\"rotor\" cx=\"{}\" cy=\"{}\" r=\"100\"/>\n</svg>\n",
            path.x[end], -path.y[end]
        ));
        out + "</svg>\n"
    }

    /// The smallest clearance between shown instants over time, with the marks.
    fn strip(&self, first: usize) -> String {
        let [width, height, left, bottom] = STRIP;
        let right = width - 8.0;
        let time = |at: usize| self.history.time[self.frames[at]];
        let last = self.frames.len() - 1;
        let x_axis = Axis::between("time [s]", (time(0), if last > 0 { time(last) } else { time(0) + 1.0 }));
        let smallest: Vec<Option<f64>> = (0..=last).map(|at| self.smallest(at)).collect();
        let values = smallest.iter().flatten().copied().chain([0.0]);
        let y_axis = Axis::numbers(self.length.label("clearance"), values).most(4);
        let frame = Frame::new(&x_axis, &y_axis, [left, 8.0, right, bottom]);
        let mut svg = Svg::default();
        svg.put(format_args!(
            "<svg class=\"film strip\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"smallest clearance over time\">"
        ));
        frame.axes(&mut svg, Ruling::Grid, left - 11.0);
        frame.line(&mut svg, "class=\"curve\"", (0..=last).filter_map(|at| Some((time(at), smallest[at]?))));
        let mut free = f64::NEG_INFINITY;
        for (number, mark) in self.marks.iter().enumerate() {
            let Some(x) = frame.across(time(mark.frame)) else { continue };
            svg.path("class=\"mark\"", format_args!("M{x:.1},8V{bottom}"));
            if x > free {
                svg.text("", ((x + 3.0).min(right - 7.0), 18.0), Anchor::Start, &(number + 1).to_string());
                free = x + 12.0;
            }
        }
        let x = frame.across(time(first)).unwrap_or(left);
        svg.path("class=\"now\" id=\"now\"", format_args!("M{x:.1},8V{bottom}"));
        svg.0 + "</svg>\n"
    }

    /// The smallest clearance since the previous frame, as text.
    fn smallest(&self, frame: usize) -> Option<f64> {
        let values = &self.clearance?.values;
        let from = if frame == 0 { self.frames[0] } else { self.frames[frame - 1] + 1 };
        let finite = values[from..=self.frames[frame]].iter().copied().filter(|value| value.is_finite());
        finite.reduce(f64::min).map(|smallest| smallest * self.length.factor)
    }
}

/// Number of decimals for four significant digits of the largest value, plus `more`.
fn digits(values: &[Value], more: i32) -> usize {
    let largest = values.iter().filter_map(Value::as_f64).fold(0.0_f64, |most, value| most.max(value.abs()));
    if largest > 0.0 { (3 + more - libm::floor(libm::log10(largest)) as i32).clamp(0, 9) as usize } else { 0 }
}

/// Points of the rotor's centre in drawing units.
struct Path {
    x: Vec<i64>,
    y: Vec<i64>,
    /// Index of the first point of each frame, and one beyond its last.
    from: Vec<usize>,
    to: Vec<usize>,
    /// Thinning: one of so many records is contained.
    every: usize,
}

#[cfg(test)]
#[path = "film_tests.rs"]
mod film_tests;
