//! The files of a law in C: which are written, what they are called, and where they do not compile.

mod c_compiler;

use assert_cmd::cargo::cargo_bin_cmd;
use c_compiler::{STRICT, answer, compile, compilers, emitted, here, run, solved};
use gain_gen::emit::{Output, write_all};

#[test]
fn todays_generator_writes_the_committed_sources() {
    let folder = tempfile::tempdir().unwrap();
    for design in ["../designs/pendulum.toml", "tests/data/crane.toml"] {
        let design = here(design);
        let header = folder.path().join(design.file_name().unwrap()).with_extension("h");
        let output = cargo_bin_cmd!("gain-gen")
            .args(["emit", "--accept-undecided-stability", "--to", "c", "--output"])
            .args([&header, &design])
            .output()
            .unwrap();
        assert!(output.status.success() && output.stdout.is_empty(), "{output:?}");
        for written in [
            header.with_extension("c"),
            header,
            folder.path().join("slqg_law.h"),
            folder.path().join("slqg_law.c"),
        ] {
            let name = written.file_name().unwrap();
            // What is the same for every design is committed once.
            let shared = name.to_string_lossy().starts_with("slqg_law");
            let committed = here(if shared { "c" } else { "tests/generated" }).join(name);
            assert!(
                std::fs::read(&written).unwrap() == std::fs::read(&committed).unwrap_or_default(),
                "{} is not what the generator writes today. If the change is wanted:\n\
                 cargo run -p gain-gen -- emit --accept-undecided-stability {} --to c --output {}",
                committed.display(),
                design.display(),
                committed.with_extension("h").display(),
            );
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 6, "temporary files were left behind");
}

#[test]
fn a_law_does_not_compile_with_another_form_of_header_or_with_reordered_sums() {
    let folder = tempfile::tempdir().unwrap();
    emitted(&solved("../designs/pendulum.toml", None, None), folder.path());
    let refused = |flags: &[&str], reason: &str| {
        let output = run("cc", folder.path(), &[flags, &["-c", "law.c", "-o", "law.o"]].concat());
        assert!(!output.status.success());
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(stderr.contains(reason), "{stderr}");
    };
    refused(&["-O2", "-ffast-math"], "without -ffast-math");
    let shared = folder.path().join("slqg_law.h");
    let text = std::fs::read_to_string(&shared).unwrap();
    let older = text.replace("#define SLQG_LAW_FORM 1u", "#define SLQG_LAW_FORM 0u");
    assert_ne!(text, older);
    std::fs::write(shared, older).unwrap();
    refused(&["-std=c99"], "written by different versions of gain-gen");
}

#[test]
fn laws_of_several_designs_are_used_by_one_source_and_linked_with_all_sources_of_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    for (design, name) in [("../designs/pendulum.toml", "arm.h"), ("tests/data/crane.toml", "crane.h")] {
        let output = folder.path().join(name);
        let files = Output::c(&output)
            .unwrap()
            .files(&solved(design, None, None).emission().unwrap(), "test.toml")
            .unwrap();
        write_all(&files).unwrap();
    }
    let source = "#include \"arm.h\"\n#include \"crane.h\"\n#include \"arm.h\"\n\
        int main(void)\n{\n    arm_state arm;\n    crane_state crane;\n\n    arm_init(&arm, 3);\n    crane_init(&crane, 4);\n    \
        return arm.tick == 3u && crane.tick == 4u && sizeof arm.applied[0] == 4u && sizeof crane.applied[0] == 8u \
        ? 0 : 1;\n}\n";
    std::fs::write(folder.path().join("main.c"), source).unwrap();
    for compiler in compilers() {
        let sources = ["main.c", "arm.c", "crane.c", "slqg_law.c", "-o", "both"];
        compile(compiler, folder.path(), &[&STRICT[..], &sources].concat());
        assert_eq!(answer(&folder.path().join("both"), ""), "");
        // The law by itself, for the design that the command line names.
        let alone = ["-DSLQG_LAW_DESIGN=\"crane.h\"", "-c", "slqg_law.c", "-o", "crane.o"];
        compile(compiler, folder.path(), &[&STRICT[..], &alone].concat());
    }
}

#[test]
fn a_file_that_is_no_header_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let emit = |name: &str, more: &[&str]| {
        let output = cargo_bin_cmd!("gain-gen")
            .args(["emit", "--to", "c", "--output"])
            .args([folder.path().join(name), here("../designs/critical.toml")])
            .args(more)
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (status, stderr) = emit("critical.c", &[]);
    assert_eq!(status, Some(2));
    assert!(stderr.contains("give a header, such as \"critical.h\""), "{stderr}");
    assert_eq!(emit("critical.h", &["--sequence-length", "2"]).0, Some(3), "it cannot be stabilised");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    // The others could be written, the source not.
    std::fs::create_dir(folder.path().join("critical.c")).unwrap();
    let (status, stderr) = emit("critical.h", &[]);
    assert_eq!(status, Some(2));
    assert!(stderr.contains("critical.c: cannot be written"), "{stderr}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn any_name_of_a_design_and_of_a_file_makes_source_that_compiles() {
    let folder = tempfile::tempdir().unwrap();
    let mut report = solved("../designs/double_integrator.toml", None, None);
    report.design.name = "*/ #error /* ?\u{3f}/ @law@ @body@ \u{202e}ä\n\\".into();
    for stem in ["int", "2nd-axis (left)", "größe", "@law@"] {
        let header = folder.path().join(format!("{stem}.h"));
        let files = Output::c(&header).unwrap().files(&report.emission().unwrap(), "*/.toml").unwrap();
        assert!(files.iter().all(|file| file.content.is_ascii() || stem == "größe"));
        write_all(&files).unwrap();
        let source = format!("{stem}.c");
        let arguments = [&STRICT[..], &["-c", &source, "-o", "law.o"]].concat();
        compile("cc", folder.path(), &arguments);
    }
}
