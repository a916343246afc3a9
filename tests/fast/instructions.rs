//! The check of instruction counts can fail, and fails only where it may.

use crate::support::instructions::{Count, Environment, Row, TOLERANCE, Table, judge, read_callgrind};

/// As callgrind writes it: names once, then numbers; the line below `calls=` is not the function's own.
const FILE: &str = "\
# callgrind format
version: 1
positions: line
events: Ir
summary: 1207

ob=(1) /usr/bin/program
fl=(1) main.rs
fn=(1) program::main
12 100
fi=(2) inlined.rs
+3 50
fe=(1)
cob=(2) /usr/lib/libembree3.so.3
cfi=(3) ???
cfn=(2) rtcIntersect1
calls=7 0
-2 1000
* 7

ob=(2)
fl=(3)
fn=(2)
0 1000
0 50

totals: 1207
";

#[test]
fn callgrind_files_are_read_by_object() {
    assert_eq!(read_callgrind(FILE, "/usr/bin/program"), Ok(Count { own: 157, all: 1207 }));
    assert_eq!(read_callgrind(FILE, "/usr/lib/libembree3.so.3"), Ok(Count { own: 1050, all: 1207 }));
    // A file that says something else than its lines do was not understood.
    assert!(read_callgrind(&FILE.replace("totals: 1207", "totals: 1208"), "/usr/bin/program").is_err());
    assert!(read_callgrind(&FILE.replace("totals: 1207", ""), "/usr/bin/program").is_err());
    assert!(read_callgrind(&FILE.replace("0 50", "0 many"), "/usr/bin/program").is_err());
    assert!(read_callgrind(&FILE.replace("ob=(2)\n", "ob=(9)\n"), "/usr/bin/program").is_err());
}

fn table(counts: [Count; 2]) -> Table {
    let environment = Environment {
        build: "debug".into(),
        rustc: "1.89.0".into(),
        target: "x86_64".into(),
        vectors: "V3".into(),
        rays: "Embree 3.13.5".into(),
        system: "debian 12".into(),
    };
    let row = |(phase, count): (&str, Count)| Row { scene: "ring".into(), phase: phase.into(), count };
    Table { environment, rows: ["photons", "estimate"].into_iter().zip(counts).map(row).collect() }
}

#[test]
fn more_than_three_per_cent_fail_either_way() {
    let same = [Count { own: 100_000, all: 300_000 }, Count { own: 500_000, all: 500_000 }];
    let before = table(same);
    let passes = |change: &dyn Fn(&mut [Count; 2])| {
        let mut counts = same;
        change(&mut counts);
        judge(&before, &table(counts)).passed
    };
    assert_eq!(TOLERANCE, 0.03);
    assert!(passes(&|_| ()));
    assert!(passes(&|counts| counts[0].own = 102_900) && passes(&|counts| counts[0].own = 97_100));
    assert!(!passes(&|counts| counts[0].own = 103_100) && !passes(&|counts| counts[1].own = 484_000));
    // Only the ray library's work grew.
    assert!(!passes(&|counts| counts[0].all = 310_000));
    let text = judge(&before, &table([same[0], Count { own: 600_000, all: 600_000 }])).text;
    assert!(text.contains("further than 3 % from the table: ring estimate") && text.contains("+20.00%"), "{text}");
}

#[test]
fn phases_that_come_or_go_fail() {
    let whole = table([Count { own: 10, all: 20 }; 2]);
    let mut less = whole.clone();
    less.rows.pop();
    let gone = judge(&whole, &less);
    assert!(!gone.passed && gone.text.contains("ring estimate (gone)"), "{}", gone.text);
    assert!(!judge(&less, &whole).passed);
}

#[test]
fn another_environment_is_shown_but_not_judged() {
    let before = table([Count { own: 10, all: 20 }; 2]);
    let mut now = table([Count { own: 100, all: 200 }; 2]);
    now.environment.rustc = "1.90.0".into();
    let verdict = judge(&before, &now);
    assert!(verdict.passed && verdict.text.contains("+900.00%"), "{}", verdict.text);
    assert!(verdict.text.contains("not judged") && verdict.text.contains("rustc 1.89.0"), "{}", verdict.text);
}
