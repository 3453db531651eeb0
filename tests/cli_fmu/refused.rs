//! Archives and descriptions that are refused, and what is said of them.

use crate::bench::{Bench, Kind};
use std::io::Write;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// That all of it is said.
fn says(said: &str, expected: &[&str]) {
    assert!(expected.iter().all(|e| said.contains(e)), "expected {expected:?}: {said}");
}

#[test]
fn archives_that_are_none_or_lead_outside_are_refused() {
    let bench = Bench::new();
    let description = Kind::new(2, false).description();
    let xml = ("modelDescription.xml", description.as_bytes());
    bench.write("plant.fmu", b"no archive");
    says(&bench.refused("plant.fmu"), &["plant.fmu: the FMU is no FMU", "ZIP"]);
    bench.archive("plant.fmu", &[("readme.txt", b"nothing")]);
    says(&bench.refused("plant.fmu"), &["has no modelDescription.xml", "readme.txt"]);
    for (name, what) in [("resources/../../evil", "outside"), ("/etc/evil", "absolute")] {
        bench.archive("plant.fmu", &[xml, (name, b"evil")]);
        says(&bench.refused("plant.fmu"), &[name, what, "not unpacked"]);
    }
    let mut zip = ZipWriter::new(std::fs::File::create(bench.path("plant.fmu")).unwrap());
    zip.add_symlink("resources/link", "/etc", SimpleFileOptions::default()).unwrap();
    zip.finish().unwrap();
    says(&bench.refused("plant.fmu"), &["resources/link", "a link"]);
}

#[test]
fn archives_that_unpack_into_too_much_are_refused() {
    let bench = Bench::new();
    let spaces = vec![b' '; 65 << 20];
    bench.archive("plant.fmu", &[("modelDescription.xml", &spaces)]);
    assert!(bench.path("plant.fmu").metadata().unwrap().len() < 1 << 20);
    says(&bench.refused("plant.fmu"), &["65 MiB", "at most 64 MiB"]);
    // The same with a size that the archive does not tell truly, in both of its headers.
    let mut bytes = std::fs::read(bench.path("plant.fmu")).unwrap();
    let size = u32::try_from(spaces.len()).unwrap().to_le_bytes();
    let places: Vec<usize> = (0..bytes.len() - 4).filter(|&k| bytes[k..k + 4] == size).collect();
    assert!(!places.is_empty());
    for k in places {
        bytes[k..k + 4].copy_from_slice(&1000u32.to_le_bytes());
    }
    bench.write("plant.fmu", &bytes);
    says(&bench.refused("plant.fmu"), &["not of 1000 bytes"]);
    let mut zip = ZipWriter::new(std::fs::File::create(bench.path("plant.fmu")).unwrap());
    for k in 0..3 {
        zip.start_file(format!("resources/{k}"), SimpleFileOptions::default()).unwrap();
        (0..11).for_each(|_| zip.write_all(&spaces).unwrap());
    }
    zip.finish().unwrap();
    says(&bench.refused("plant.fmu"), &["at most 2048 MiB"]);
}

#[test]
fn what_is_not_supported_is_said() {
    let bench = Bench::new();
    let refused = |version: usize, from: &str, to: &str| {
        let description = Kind::new(version, false).description();
        assert!(description.contains(from), "{from}");
        let edited = description.replace(from, to);
        bench.archive(
            "plant.fmu",
            &[
                ("modelDescription.xml", edited.as_bytes()),
                ("binaries/win64/arm.dll", b"a library"),
            ],
        );
        bench.refused("plant.fmu")
    };
    says(&refused(2, "ModelExchange", "CoSimulation"), &["co-simulation alone", "model exchange"]);
    says(
        &refused(2, "Indicators=\"0\"", "Indicators=\"3\""),
        &["3 event indicators", "state events"],
    );
    says(&refused(3, "<Output valueReference", "<EventIndicator valueReference"), &["1 event ind"]);
    let discrete = "<DiscreteStates><Unknown index=\"1\"/></DiscreteStates></ModelStructure>";
    says(&refused(2, "</ModelStructure>", discrete), &["1 discrete states"]);
    says(&refused(2, "fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""), &["FMI '1.0'"]);
    let whole = "<Real unit=\"N.m\" start=\"0\"/>";
    says(&refused(2, whole, "<Integer start=\"0\"/>"), &["an input 'tau' of type Integer"]);
    let array = "unit=\"N.m\" start=\"0\"><Dimension start=\"3\"/></Float64>";
    says(&refused(3, "unit=\"N.m\" start=\"0\"/>", array), &["'tau' that is an array"]);
    says(&refused(2, "derivative=\"1\"", "derivative=\"77\""), &["line 13", "\"77\"", "no such"]);
    says(&refused(2, "</ModelVariables>", ""), &["modelDescription.xml, line"]);
    says(&refused(2, "modelName=\"arm\"", "modelName=\"arm\" "), &["/arm.", "win64"]);
}

#[test]
fn what_shows_only_when_it_runs_is_said() {
    let bench = Bench::new();
    let refused = |kind: Kind, edit: &dyn Fn(&str) -> String| {
        bench.fmu("plant.fmu", kind, edit)?;
        Some(bench.refused("plant.fmu"))
    };
    let plain = Kind::new(2, false);
    let with = |define| Kind { define, ..plain };
    let Some(said) = refused(with("-DCRASH_AT=-1"), &str::to_owned) else { return };
    says(&said, &["cannot be evaluated where it starts", "SIGABRT"]);
    let said = refused(with("-DLATER=2.5"), &str::to_owned).unwrap();
    says(&said, &["event at 2.5 s", "time event"]);
    let said = refused(plain, &|text| text.replace("guid=\"{arm}\"", "guid=\"{leg}\"")).unwrap();
    says(&said, &["cannot be instantiated"]);
    let said = refused(plain, &|text| text.replace("unit=\"rad/s\" start", "unit=\"m/s\" start"));
    says(&said.unwrap(), &["'dq' in m/s", "'q'", "expected rad/s"]);
    bench.archive(
        "plant.fmu",
        &[
            ("modelDescription.xml", plain.description().as_bytes()),
            (&plain.library(), b"no library"),
        ],
    );
    says(&bench.refused("plant.fmu"), &["library cannot be loaded"]);
}

#[test]
fn mistakes_beside_an_fmu_have_their_place() {
    let bench = Bench::new();
    let Some(()) = bench.fmu("plant.fmu", Kind::new(2, false), str::to_owned) else { return };
    let refused = |more: &str| {
        let text = format!("name = \"arm\"\n[fmu]\nfile = \"plant.fmu\"\n{more}");
        bench.write("arm.toml", text.as_bytes());
        bench.refused("arm.toml")
    };
    says(
        &refused("[parameters]\nJ = { value = 1, unit = \"m\" }\n"),
        &["arm.toml:5", "'J' in kg m2"],
    );
    says(&refused("[parameters]\nJ = { value = 0 }\n"), &["arm.toml:5", "between 0.001 and inf"]);
    says(&refused("[parameters]\nK = { value = 0 }\n"), &["arm.toml:5", "no parameter 'K'", "mgl"]);
    says(&refused("[[state]]\nname = \"x\"\nderivative = \"1\"\n"), &["[[state]] cannot stand"]);
    let column = "[[measurement]]\ncolumn = \"c\"\nof = \"speed\"\n";
    says(&refused(column), &["arm.toml:6", "'speed'", "turn"]);
    says(&refused("[[input]]\nname = \"tau\"\nunit = \"N\"\n"), &["arm.toml:5", "'tau' in N m"]);
    bench.write("arm.toml", b"name = \"arm\"\n[fmu]\nfile = \"none.fmu\"\n");
    says(&bench.refused("arm.toml"), &["arm.toml:3", "none.fmu is not there"]);
}
