//! Tables that become lists on narrow screens.

use maud::{Markup, html};

/// A table; the first cell of each row is its heading.
pub(crate) fn table(caption: &str, head: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        table {
            caption { (caption) }
            thead { tr { @for cell in head { th scope="col" { (cell) } } } }
            tbody {
                @for row in rows {
                    tr {
                        @for (k, (cell, name)) in row.iter().zip(head).enumerate() {
                            @if k == 0 { th scope="row" { (cell) } }
                            @else { td data-label=(name) { (cell) } }
                        }
                    }
                }
            }
        }
    }
}
