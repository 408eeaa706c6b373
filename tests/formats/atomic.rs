use std::fs;
use std::io;

use hitl_slam::error::Error;
use hitl_slam::io::atomic;

use crate::support::Scratch;

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let scratch = Scratch::new("atomic");
    let path = scratch.file("map.g2o", "old");
    let result = atomic::write(&path, |out| {
        out.write_all(b"half of the new")?;
        Err(io::Error::other("no space left"))
    });
    assert!(matches!(result, Err(Error::Io { .. })));
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(fs::read_dir(scratch.path("")).unwrap().count(), 1, "the temporary file is gone");
}

#[test]
fn folders_of_an_output_are_made() {
    let scratch = Scratch::new("atomic-folders");
    let path = scratch.path("a/b/c.txt");
    atomic::write(&path, |out| out.write_all(b"x")).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "x");
}
