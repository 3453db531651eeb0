//! The page of a fleet: many machines with one model.

use super::{POLICY, SCRIPT, STYLE, figure};
use crate::pictures::{Drawing, Picture};
use lacuna_charts::Figure;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// What the page says.
#[derive(Clone, Debug)]
pub struct FleetPage {
    /// Name of the model.
    pub model: String,
    /// Sentences; the first is the heading.
    pub says: Vec<String>,
    /// Machines that are unlike the others, and why.
    pub unlike: FleetTable,
    /// What each machine lacks.
    pub machines: FleetTable,
    /// How the numbers are spread.
    pub spread: FleetTable,
    /// The numbers of all machines.
    pub figures: Vec<Figure>,
    /// Numbers that are compared and not drawn.
    pub undrawn: usize,
    /// Machines that could not be diagnosed.
    pub failed: FleetTable,
}

/// A table.
#[derive(Clone, Debug)]
pub struct FleetTable {
    /// Headings.
    pub head: Vec<String>,
    /// Rows.
    pub rows: Vec<FleetRow>,
}

/// A row of as many cells as there are headings.
#[derive(Clone, Debug)]
pub struct FleetRow {
    /// Where its first cell leads, if anywhere.
    pub link: Option<String>,
    /// Its cells; the first is its heading.
    pub cells: Vec<String>,
}

impl FleetRow {
    /// A row that leads nowhere.
    #[must_use]
    pub fn of(cells: Vec<String>) -> Self {
        Self { link: None, cells }
    }
}

/// The page: one file that needs nothing else (its links lead to the pages of the machines), in the look of the
/// diagnosis' [`page`](super::page).
#[must_use]
pub fn fleet_page(f: &FleetPage) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { "Lacuna: machines with " (f.model) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header { p.brand { "Lacuna · machines with the model " strong { (f.model) } } }
                main {
                    section aria-labelledby="title" {
                        h1 #title { (f.says.first().map_or("", String::as_str)) }
                        @for more in f.says.iter().skip(1) { p.about { (more) } }
                        @if !f.unlike.rows.is_empty() {
                            (table(&f.unlike))
                            p.about {
                                "Of the machines called unlike, at most 1 % are not, on average (Benjamini and Hochberg). "
                                "The chance takes into account how uncertain each number is, how much typical machines "
                                "differ, and in how many numbers a machine was compared."
                            }
                        }
                    }
                    (part("failed", "Not diagnosed", &f.failed))
                    (part("machines", "What each machine lacks", &f.machines))
                    (part("spread", "How much machines differ", &f.spread))
                    @if !f.figures.is_empty() {
                        section aria-labelledby="values" {
                            h2 #values { "Every machine's numbers" }
                            p.about {
                                "The band is where 95 % of typical machines are. What was not found in a machine "
                                "counts as 0."
                            }
                            div.figures { @for one in &f.figures { (drawn(one)) } }
                            @if f.undrawn > 0 { p.about { (f.undrawn) " more are not drawn." } }
                        }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// A section with a table, where the table has rows.
fn part(id: &str, title: &str, rows: &FleetTable) -> Markup {
    html! {
        @if !rows.rows.is_empty() {
            section aria-labelledby=(id) { h2 id=(id) { (title) } (table(rows)) }
        }
    }
}

fn table(table: &FleetTable) -> Markup {
    html! {
        table {
            thead { tr { @for cell in &table.head { th scope="col" { (cell) } } } }
            tbody { @for row in &table.rows { (line(row, &table.head)) } }
        }
    }
}

fn line(row: &FleetRow, head: &[String]) -> Markup {
    let first = row.cells.first().map_or("", String::as_str);
    html! {
        tr {
            th scope="row" {
                @match &row.link { Some(link) => a href=(link) { (first) }, None => (first) }
            }
            @for (cell, name) in row.cells.iter().zip(head).skip(1) { td data-label=(name) { (cell) } }
        }
    }
}

fn drawn(one: &Figure) -> Markup {
    figure(&Picture {
        kind: "fleet",
        of: one.y.name.clone(),
        caption: one.description.clone(),
        drawing: Drawing::Figure(Box::new(one.clone())),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_its_tables_escaped_and_leaves_out_what_is_empty() {
        let head = vec!["Machine".to_owned(), "Why".to_owned()];
        let row = |link: Option<&str>| FleetRow {
            link: link.map(str::to_owned),
            cells: vec!["<m 1>".to_owned(), "why & how".to_owned()],
        };
        let none = FleetTable { head: head.clone(), rows: vec![] };
        let page = fleet_page(&FleetPage {
            model: "arm".into(),
            says: vec!["One is unlike.".into(), "more".into()],
            unlike: FleetTable { head: head.clone(), rows: vec![row(Some("m%201/report.html"))] },
            machines: FleetTable { head, rows: vec![row(None)] },
            spread: none.clone(),
            figures: vec![],
            undrawn: 0,
            failed: none,
        });
        assert!(page.contains("<a href=\"m%201/report.html\">&lt;m 1&gt;</a>"), "{page}");
        assert!(page.contains("data-label=\"Why\">why &amp; how"), "{page}");
        assert!(
            page.contains("What each machine lacks") && !page.contains("Not diagnosed"),
            "{page}"
        );
    }
}
