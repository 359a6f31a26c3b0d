//! Robot descriptions that are refused, each with its one message.

use super::{URDF, accept_urdf, changed, check_urdf};

#[test]
fn one_message_each() {
    let cases: Vec<(&str, String, &str)> = vec![
        (
            "loop",
            changed(
                URDF,
                "</robot>",
                "<joint name=\"J2\" type=\"fixed\"><parent link=\"tool\"/><child link=\"base\"/></joint></robot>",
            ),
            "arm.urdf:4: joint 'J1' is part of a loop that reaches no root link; a robot description is a tree, remove one joint of the loop",
        ),
        (
            "two parents",
            changed(
                URDF,
                "</robot>",
                "<link name=\"c\"/><joint name=\"J2\" type=\"fixed\"><parent link=\"base\"/><child link=\"c\"/></joint>\n<joint name=\"J3\" type=\"fixed\"><parent link=\"c\"/><child link=\"tool\"/></joint></robot>",
            ),
            "arm.urdf:11: link 'tool' is carried by joint 'J1' and by joint 'J3': the joints form a loop; a link has one parent",
        ),
        (
            "loop apart",
            changed(
                URDF,
                "</robot>",
                "<link name=\"c\"/><link name=\"d\"/><joint name=\"J2\" type=\"fixed\"><parent link=\"d\"/><child link=\"c\"/></joint>\n<joint name=\"J3\" type=\"fixed\"><parent link=\"c\"/><child link=\"d\"/></joint></robot>",
            ),
            "arm.urdf:10: joint 'J2' is part of a loop that reaches no root link; a robot description is a tree, remove one joint of the loop",
        ),
        (
            "mesh missing",
            changed(
                URDF,
                "<link name=\"tool\"/>",
                "<link name=\"tool\"><collision><geometry>\n<mesh filename=\"tool.stl\"/></geometry></collision></link>",
            ),
            "arm.urdf:4: mesh 'tool.stl' is not there; put the file beside the robot description or remove the mesh",
        ),
        (
            "mesh ..",
            changed(
                URDF,
                "<link name=\"tool\"/>",
                "<link name=\"tool\"><collision><geometry>\n<mesh filename=\"../tool.stl\"/></geometry></collision></link>",
            ),
            "arm.urdf:4: mesh '../tool.stl' leaves the file's folder; put it beside the file and name it relative to the file",
        ),
        (
            "mesh abs",
            changed(
                URDF,
                "<link name=\"tool\"/>",
                "<link name=\"tool\"><collision><geometry>\n<mesh filename=\"/etc/passwd\"/></geometry></collision></link>",
            ),
            "arm.urdf:4: mesh '/etc/passwd' leaves the file's folder; put it beside the file and name it relative to the file",
        ),
        (
            "mesh pkg",
            changed(
                URDF,
                "<link name=\"tool\"/>",
                "<link name=\"tool\"><collision><geometry>\n<mesh filename=\"package://arm/tool.stl\"/></geometry></collision></link>",
            ),
            "arm.urdf:4: mesh 'package://arm/tool.stl' is not there: not below a folder 'arm' that holds the robot description or lies beside its folders, and not beside it; put the file there or remove the mesh",
        ),
        (
            "words in xyz",
            changed(URDF, "xyz=\"0 0 1\"", "xyz=\"1 abc 2 3\""),
            "arm.urdf:7: <axis> has xyz=\"1 abc 2 3\"; 3 finite numbers of at most 10000 are due",
        ),
        (
            "nan axis",
            changed(URDF, "xyz=\"0 0 1\"", "xyz=\"0 0 nan\""),
            "arm.urdf:7: <axis> has xyz=\"0 0 nan\"; 3 finite numbers of at most 10000 are due",
        ),
        (
            "zero axis",
            changed(URDF, "xyz=\"0 0 1\"", "xyz=\"0 0 0\""),
            "arm.urdf:4: joint 'J1' has an axis of no length; give a direction such as xyz=\"0 0 1\"",
        ),
        (
            "range",
            changed(URDF, "lower=\"-1\"", "lower=\"2\""),
            "arm.urdf:8: joint 'J1' has the range 2 … 1, upside down or empty; lower is below upper",
        ),
        (
            "type",
            changed(URDF, "revolute", "floating"),
            "arm.urdf:4: joint 'J1' has the type 'floating'; allowed are revolute, continuous, prismatic and fixed",
        ),
        (
            "no parent",
            changed(URDF, "<parent link=\"base\"/>\n", ""),
            "arm.urdf:4: joint 'J1' has no parent; write <parent link=\"…\"/>",
        ),
        (
            "unknown parent",
            changed(URDF, "<parent link=\"base\"/>", "<parent link=\"bsae\"/>"),
            "arm.urdf:4: joint 'J1' has the parent 'bsae', which is no link of the file; did you mean 'base'?",
        ),
        (
            "dup link",
            changed(URDF, "<link name=\"tool\"/>", "<link name=\"tool\"/><link name=\"tool\"/>"),
            "arm.urdf:3: link 'tool' stands twice; each link has its own name",
        ),
        (
            "root",
            changed(URDF, "robot", "model"),
            "arm.urdf:1: the root element is <model>; a robot description starts with <robot>",
        ),
        (
            "cut",
            URDF[..150].into(),
            "arm.urdf:7: attribute xyz of <axis> is not closed by '\"'; the file may be cut off",
        ),
        ("cut2", URDF[..URDF.len() - 9].into(), "arm.urdf:1: <robot> is not closed; the file may be cut off"),
        (
            "deep",
            format!("<robot>{}", "<a>".repeat(20_000)),
            "arm.urdf:1: is nested deeper than 64 levels; no robot description needs that",
        ),
        (
            "entity",
            format!("<!DOCTYPE x [<!ENTITY a \"b\">]>{URDF}"),
            "arm.urdf:1: holds a document type or entities (<!…>); a robot description has none, remove it",
        ),
        (
            "two roots",
            changed(URDF, "</robot>", "<link name=\"c\"/></robot>"),
            "arm.urdf: links base, c hang on nothing; one root link is allowed, join the others to it by joints",
        ),
        (
            "ambiguous",
            changed(
                &changed(URDF, "\"tool\"", "\"hand\""),
                "</robot>",
                "<link name=\"c\"/><joint name=\"J2\" type=\"continuous\"><parent link=\"base\"/><child link=\"c\"/></joint></robot>",
            ),
            "arm.urdf: which link is the tool is not clear; name it with --tool-link or call it tool, tool0, tcp, tool_link, spindle, spindle_link, flange, ee_link, end_effector (links: base hand c)",
        ),
        ("empty urdf", "".into(), "arm.urdf: holds no element; a robot description starts with <robot>"),
    ];
    for (name, text, message) in cases {
        check_urdf(name, &text, message);
    }
}

#[test]
fn odd_but_sound_files_are_accepted() {
    let cases: Vec<(&str, String)> = vec![("urdf", URDF.into())];
    for (name, text) in cases {
        accept_urdf(name, &text);
    }
}
