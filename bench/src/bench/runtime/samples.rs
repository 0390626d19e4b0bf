//! Times as a row of a table: quantiles and a histogram.

/// The upper bounds of the columns, in microseconds.
const BOUNDS: [u64; 8] = [20, 50, 100, 200, 500, 1_000, 5_000, 20_000];

/// Times in nanoseconds, in ascending order.
pub(super) struct Samples(Vec<u64>);

/// Returns the head of the table.
pub(super) fn header() -> String {
    let bounds: Vec<String> = BOUNDS.iter().map(|bound| format!("< {bound}")).collect();
    let names = format!("| µs | number | p50 | p99 | max | {} | more |", bounds.join(" | "));
    format!("{names}\n|{}", " --- |".repeat(BOUNDS.len() + 6))
}

impl Samples {
    /// Creates samples from times in nanoseconds.
    pub(super) fn new(mut nanos: Vec<u64>) -> Samples {
        nanos.sort_unstable();
        Samples(nanos)
    }

    /// Prints the row: number, quantiles in microseconds, and the percentage of each column.
    pub(super) fn print(&self, name: &str) {
        let number = self.0.len();
        let (Some(last), true) = (number.checked_sub(1), number > 0) else {
            println!("| {name} | 0 |");
            return;
        };
        let micros = |quantile: f64| self.0[(last as f64 * quantile) as usize] as f64 / 1e3;
        let mut row = format!("| {name} | {number}");
        for quantile in [0.5, 0.99, 1.0] {
            row += &format!(" | {:.0}", micros(quantile));
        }
        let mut below = 0;
        let bounds = BOUNDS.iter().map(|bound| bound * 1_000);
        for bound in bounds.chain([u64::MAX]) {
            let count = self.0.partition_point(|&nanos| nanos < bound);
            row += &format!(" | {}", percentage(count - below, number));
            below = count;
        }
        println!("{row} |");
    }
}

/// A percentage; nothing for none.
fn percentage(part: usize, whole: usize) -> String {
    match part {
        0 => String::new(),
        part => format!("{:.2} %", 100.0 * part as f64 / whole as f64),
    }
}
