//! HTML text of a page.

use super::block::{Block, Page, Section};
use super::escape::{html, json};
use super::figure::Figure;
use super::table::Table;
use serde_json::{Map, Value};

/// Plotly 4.1.1, cartesian bundle, as published on npm (`plotly.js-cartesian-dist-min`).
const LIBRARY: &str = include_str!("plotly/plotly-cartesian.min.js");
const LICENSE: &str = include_str!("plotly/LICENSE");
const SCRIPT: &str = include_str!("page.js");
pub(super) const STYLE: &str = include_str!("page.css");
/// SHA-256 of both scripts in the page's policy; a test compares them.
const HASHES: [&str; 2] =
    ["eVQhUIVaUsVnJg4xNwldvit0Tm1wKlyr5n2iRpQvuno=", "GovJ2QXVkyh04OiXKhKl8jm9p+1emZYv6Vr0tpdcA2E="];

impl Page {
    /// Text of the HTML file.
    #[must_use]
    pub fn html(&self) -> String {
        let mut body = Body::default();
        body.put(&format!("<header>\n<h1>{}</h1>\n", html(&self.title)));
        self.lead.iter().for_each(|block| body.block(block));
        body.put("</header>\n");
        body.contents(&self.sections);
        body.put("<main id=\"content\">\n");
        for section in &self.sections {
            body.put(&format!(
                "<section id=\"{id}\" aria-labelledby=\"{id}-heading\">\n<h2 id=\"{id}-heading\"><a href=\"#{id}\">{}</a></h2>\n",
                html(&section.heading),
                id = section.id
            ));
            section.blocks.iter().for_each(|block| body.block(block));
            body.put("</section>\n");
        }
        body.put("</main>\n");
        body.footer();
        let [library, script] = HASHES;
        let policy = format!(
            "default-src 'none'; script-src 'sha256-{library}' 'sha256-{script}'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
        );
        let reload = self.reload.map(|seconds| format!("<meta http-equiv=\"refresh\" content=\"{seconds}\">\n"));
        let reload = reload.unwrap_or_default();
        let figures = json(&Value::Object(body.plots));
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"referrer\" content=\"no-referrer\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"bladeoff\">\n{reload}<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <a class=\"skip\" href=\"#content\">Skip to the content</a>\n{body}\
             <script type=\"application/json\" id=\"figures\">{figures}</script>\n\
             <script>{LIBRARY}</script>\n<script>{SCRIPT}</script>\n</body>\n</html>\n",
            title = html(&format!("{} \u{2013} bladeoff report", self.title)),
            body = body.text,
        )
    }
}

/// Longest cell that counts as a number with its unit instead of a sentence that begins with a number \[bytes\].
const MOST_NUMBER: usize = 24;

#[derive(Default)]
struct Body {
    text: String,
    /// Chart data by the id of its element.
    plots: Map<String, Value>,
    figures: usize,
}

impl Body {
    fn put(&mut self, text: &str) {
        self.text.push_str(text);
    }

    fn element(&mut self, name: &str, class: &str, text: &str) {
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        self.put(&format!("<{name}{class}>{}</{name}>\n", html(text)));
    }

    fn contents(&mut self, sections: &[Section]) {
        if sections.len() < 2 {
            return;
        }
        self.put("<nav aria-label=\"Contents\">\n<ul>\n");
        for section in sections {
            self.put(&format!("<li><a href=\"#{}\">{}</a></li>\n", section.id, html(&section.heading)));
        }
        self.put("</ul>\n</nav>\n");
    }

    fn block(&mut self, block: &Block) {
        match block {
            Block::Heading(text) => self.element("h3", "", text),
            Block::Text(text) => self.element("p", "", text),
            Block::Verdict(text) => self.element("p", "verdict", text),
            Block::Note(text) => self.element("p", "note", text),
            Block::Warning(text) => self.element("p", "warning", text),
            Block::List(lines) => {
                self.put("<ul>\n");
                lines.iter().for_each(|line| self.element("li", "", line));
                self.put("</ul>\n");
            }
            Block::Table(table) => self.table(table),
            // HTML ignores a line feed after <pre>
            Block::Verbatim(text) => self.put(&format!("<pre tabindex=\"0\">\n{}</pre>\n", html(text))),
            Block::Figure(figure) => self.figure(figure),
            Block::Details(summary, blocks) => {
                self.put(&format!("<details>\n<summary>{}</summary>\n", html(summary)));
                blocks.iter().for_each(|block| self.block(block));
                self.put("</details>\n");
            }
        }
    }

    fn table(&mut self, table: &Table) {
        // on a narrow page, rows with more than two columns are stacked, each cell with its column name
        let is_stacked = table.head.len() > 2;
        let class = if is_stacked { "table stacked" } else { "table" };
        self.put(&format!("<div class=\"{class}\" tabindex=\"0\">\n<table>\n<thead><tr>"));
        let is_number = |cell: &String| {
            cell.len() <= MOST_NUMBER
                && (cell.is_empty()
                    || cell.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '\u{2212}' | '\u{2013}')))
        };
        let filled = |at: usize| table.rows.iter().any(|row| row.get(at).is_some_and(|cell| !cell.is_empty()));
        let right: Vec<bool> = (0..table.head.len())
            .map(|at| {
                !table.verbatim.contains(&at)
                    && filled(at)
                    && table.rows.iter().all(|row| row.get(at).is_none_or(is_number))
            })
            .collect();
        let class = |at: usize| if right.get(at) == Some(&true) { " class=\"number\"" } else { "" };
        // a column without any content is not shown
        let is_shown = |at: usize| table.rows.is_empty() || filled(at);
        for (at, name) in table.head.iter().enumerate().filter(|(at, _)| is_shown(*at)) {
            self.put(&format!("<th scope=\"col\"{}>{}</th>", class(at), html(name)));
        }
        self.put("</tr></thead>\n<tbody>\n");
        for row in &table.rows {
            self.put("<tr>");
            for (at, cell) in row.iter().enumerate().filter(|(at, _)| is_shown(*at)) {
                let text = html(cell);
                let text = if table.verbatim.contains(&at) { format!("<code>{text}</code>") } else { text };
                let head = table.head.get(at).filter(|head| is_stacked && !head.is_empty());
                let head = head.map_or(String::new(), |head| format!(" data-head=\"{}\"", html(head)));
                self.put(&format!("<td{}{head}>{text}</td>", class(at)));
            }
            self.put("</tr>\n");
        }
        self.put("</tbody>\n</table>\n</div>\n");
    }

    fn figure(&mut self, figure: &Figure) {
        self.figures += 1;
        let id = format!("figure-{}", self.figures);
        let caption = html(&figure.caption);
        self.put(&format!(
            "<figure id=\"{id}\">\n<div class=\"drawing\" role=\"img\" aria-label=\"{caption}\">{}</div>\n",
            figure.drawing
        ));
        if let Some(plot) = &figure.plot {
            // shown by the script that fills it
            self.put("<div class=\"plot\" hidden></div>\n");
            self.plots.insert(id, plot.json());
        }
        self.put(&format!("<figcaption>{caption}</figcaption>\n"));
        if let Some(table) = &figure.table {
            self.block(&Block::Details("Numbers".to_owned(), vec![Block::Table(table.clone())]));
        }
        self.put("</figure>\n");
    }

    fn footer(&mut self) {
        self.put("<footer>\n");
        self.element(
            "p",
            "scripted note",
            "Figures: drag to zoom, double-click to see all again, click a name to hide it. By keyboard: Tab to a figure, arrows to move, + and - to zoom, 0 to see all again.",
        );
        let licence = vec![
            Block::Text("Zoom and hover by plotly.js 4.1.1, cartesian bundle.".to_owned()),
            Block::Verbatim(LICENSE.to_owned()),
        ];
        self.block(&Block::Details("Licence of the chart library in this page".to_owned(), licence));
        self.put("</footer>\n");
    }
}

#[cfg(test)]
#[path = "shell_tests.rs"]
pub(super) mod shell_tests;
