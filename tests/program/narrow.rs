//! The page of `report` on a telephone: at a width of 390 px nothing scrolls sideways and no text of a chart is cut.

use crate::report::{STUDY, browser, page, run};
use crate::support::skipped::skipped;
use crate::support::{Folder, say};
use std::fs;
use std::process::Command;

/// Script that measures the page after the chart library has drawn, and sends one line for the page and one for each cut text.
const PROBE: &str = r#"<script>
const measure = () => {
  if (!document.documentElement.dataset.drawn) return setTimeout(measure, 50);
  let titles = 0;
  const cut = [];
  for (const svg of document.querySelectorAll('svg.main-svg, svg.chart')) {
    const frame = svg.getBoundingClientRect();
    for (const text of frame.width ? svg.querySelectorAll('text') : []) {
      const box = text.getBoundingClientRect();
      if (!box.width) continue;
      titles += /^[xy]\d*title/.test(text.getAttribute('class') || '');
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
        cut.push('cut: ' + text.textContent);
    }
  }
  const root = document.documentElement;
  const wide = root.scrollWidth > innerWidth ? 'wider' : 'fits';
  parent.postMessage([`${innerWidth} px, ${root.dataset.drawn} drawn, ${wide}, ${titles} titles`, ...cut].join('\n'), '*');
};
measure();
</script>"#;

const FRAME: &str = r#"<!DOCTYPE html><body><iframe src="inner.html" width="390" height="800" style="border: 0"></iframe><pre></pre>
<script>addEventListener('message', (event) => { document.querySelector('pre').textContent = event.data; });</script>"#;

/// Output of the probe for this page in a frame of 390 px.
fn measured(folder: &Folder, browser: &str, page: &str) -> String {
    let (head, rest) = page.split_once("<meta http-equiv=\"Content-Security-Policy\"").expect("a policy");
    // the content security policy would block the probe
    let rest = rest.split_once('>').expect("its end").1;
    let (before, _) = rest.rsplit_once("</body>").expect("the end of the page");
    folder.write("inner.html", &format!("{head}{before}{PROBE}</body></html>"));
    let frame = folder.write("frame.html", FRAME);
    let opened = Command::new("timeout")
        .args(["600", browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"])
        .args(["--virtual-time-budget=30000", "--disable-background-networking"])
        .arg(format!("--user-data-dir={}", folder.name("profile")))
        .args(["--dump-dom", &format!("file://{frame}")])
        .output()
        .expect("it starts");
    let dom = String::from_utf8_lossy(&opened.stdout);
    let text = dom.split_once("<pre>").and_then(|(_, rest)| rest.split_once("</pre>")).expect("the frame's text").0;
    text.to_owned()
}

#[test]
fn a_page_fits_a_telephone_and_cuts_no_text_of_a_chart() {
    let Some(browser) = browser() else {
        skipped("the page of `report` at 390 px in a browser", "no chromium-headless-shell and no chromium");
        return;
    };
    let folder = Folder::new();
    let study = folder.small_study();
    let rubs = folder.name("rubs");
    assert_eq!(say(&["run", &study, "--out", &rubs]).code, 0);
    for (directory, least) in [(run(&folder, STUDY), 14), (rubs, 4)] {
        let text = page(&folder, &directory, "a.html");
        let figures = text.matches("class=\"plot\"").count();
        let found = measured(&folder, browser, &text);
        let mut lines = found.lines();
        let titles = lines
            .next()
            .and_then(|line| line.strip_prefix(&format!("390 px, {figures} of {figures} drawn, fits, ")))
            .and_then(|rest| rest.strip_suffix(" titles"))
            .and_then(|number| number.parse::<usize>().ok());
        assert!(titles.is_some_and(|titles| titles >= least), "{least} titles: {found}");
        assert_eq!(lines.next(), None, "{found}");
    }
    let regimes = fs::read_to_string(folder.name("a.html")).expect("the last page");
    assert!(regimes.contains("share of the runs that have one [%]"), "the widest title is in it");
}
