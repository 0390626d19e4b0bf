//! Generating files: the messages to clients, and the rule that files are written only after consent.

use serde_json::{Value, json};

use super::client::{Client, Folder, document};

const LAMP: &str = "component lamp {
  version \"1.0\"; lang \"c\";
  ids { boolean on; };
  task blink { period 10 ms; codel<start> lampStart(out on) yield ether; };
};
";

fn able() -> Value {
    json!({
        "textDocument": {
            "diagnostic": {},
            "codeAction": { "codeActionLiteralSupport": { "codeActionKind": { "valueSet": [] } } },
        },
        "workspace": {
            "applyEdit": true,
            "workspaceEdit": {
                "documentChanges": true,
                "resourceOperations": ["create"],
                "changeAnnotationSupport": {},
            },
        },
    })
}

/// A server on a folder with a component and templates; `more` are additional files of the folder.
async fn start(capabilities: Value, trusted: bool, more: &[(&str, &str)]) -> (Client, Folder) {
    let mut files = vec![
        ("lamp.gen", LAMP),
        ("dotgen.toml", "template-paths = [\"templates\"] # ours\n"),
        (
            "templates/names/template.toml",
            "about = \"names\"\n[[files]]\neach = \"component\"\npath = \"{{ component.name }}.txt\"\nsource = \"names.jinja\"\npermissions = \"a+x\"\n",
        ),
        ("templates/names/names.jinja", "{{ component.name }}\n{{ terse }}\n"),
    ];
    files.extend_from_slice(more);
    let folder = Folder::new(&files);
    let mut params = folder.params(capabilities);
    params["initializationOptions"] = json!({ "trusted": trusted });
    let answers = vec![
        ("window/workDoneProgress/create", Value::Null),
        ("workspace/applyEdit", json!({ "applied": true })),
    ];
    let mut client = Client::start_answering(params, answers).await;
    client.open(&folder.uri("lamp.gen"), LAMP).await;
    (client, folder)
}

fn command(name: &str, argument: Value) -> Value {
    json!({ "command": name, "arguments": [argument] })
}

#[tokio::test(flavor = "multi_thread")]
async fn templates_are_listed_with_their_options() {
    let (mut client, folder) = start(able(), true, &[]).await;
    let uri = folder.uri("lamp.gen");
    let execute = "workspace/executeCommand";
    let list = client.ok(execute, command("dotgen.templates", json!({ "uri": uri }))).await;
    let kind = |name: &str| {
        let all = list["templates"].as_array().unwrap();
        let found = all.iter().find(|template| template["name"] == name);
        found.map(|template| template["kind"].as_str().unwrap().to_owned())
    };
    assert_eq!(kind("names").as_deref(), Some("minijinja"));
    assert_eq!(kind("skeleton").as_deref(), Some("builtin"));
    let asked = json!({ "uri": uri, "template": "names" });
    let options = client.ok(execute, command("dotgen.templateOptions", asked)).await;
    let options = options["options"].as_array().unwrap();
    let directory = options.iter().find(|option| option["flags"][1] == "--directory").unwrap();
    assert_eq!(directory["value"], "DIR");
    client.finish().await;
}

/// A folder of the workspace that is named like a template of dotgen.
#[tokio::test(flavor = "multi_thread")]
async fn templates_of_the_workspace_do_not_replace_those_of_dotgen() {
    let own = [("templates/skeleton/template.tcl", "template link file puts victim.txt\n")];
    let (mut client, folder) = start(able(), true, &own).await;
    let uri = folder.uri("lamp.gen");
    let execute = "workspace/executeCommand";
    let list = client.ok(execute, command("dotgen.templates", json!({ "uri": uri }))).await;
    let all = list["templates"].as_array().expect("a list");
    let found: Vec<&Value> = all.iter().filter(|one| one["name"] == "skeleton").collect();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0]["kind"], "builtin");
    let params = json!({ "uri": uri, "template": "skeleton", "arguments": [], "apply": false });
    let plan = client.ok(execute, command("dotgen.generate", params)).await;
    let files = plan["files"].as_array().expect("files of the skeleton");
    assert!(
        files.iter().any(|file| file["uri"] == folder.uri("codels/lamp_blink_codels.c")),
        "{plan}"
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn files_are_offered_then_remembered_and_made_again() {
    let (mut client, folder) = start(able(), true, &[]).await;
    let uri = folder.uri("lamp.gen");
    let execute = "workspace/executeCommand";
    // No choice is stored yet.
    let error = client
        .request(execute, command("dotgen.regenerate", json!({ "uri": uri })))
        .await
        .unwrap_err();
    assert_eq!(error["code"], -32803, "{error}");
    // A client that shows the changes itself.
    let params = json!({ "uri": uri, "template": "names", "arguments": ["-t"], "apply": false });
    let plan = client.ok(execute, command("dotgen.generate", params.clone())).await;
    assert_eq!(plan["status"], "preview");
    assert_eq!(plan["files"][0]["uri"], folder.uri("lamp.txt"));
    assert_eq!(plan["files"][0]["after"], "lamp\nTrue\n");
    assert_eq!(plan["files"][0]["mode"], 0o755);
    assert_eq!(plan["files"][0]["concern"], "executable");
    assert!(!folder.exists("lamp.txt"), "a plan writes nothing");
    // A client that relies on the server, which asks with the names of the files.
    let mut params = params;
    params["apply"] = json!(true);
    client.answer("window/showMessageRequest", json!({ "title": "Write" }));
    let done = client.ok(execute, command("dotgen.generate", params)).await;
    assert_eq!(done["status"], "applied");
    let edit = client.asked.iter().rev().find(|message| message["method"] == "workspace/applyEdit");
    let edit = &edit.unwrap()["params"]["edit"];
    assert_eq!(edit["documentChanges"][0]["kind"], "create");
    assert_eq!(edit["changeAnnotations"], Value::Null, "asked once only");
    assert_eq!(
        folder.read("dotgen.toml"),
        "template-paths = [\"templates\"] # ours\n\n[[generate]]\nfile = \"lamp.gen\"\n\
         template = \"names\"\narguments = [\"-t\"]\n"
    );
    // The client created the file; the user changed it.
    folder.write("lamp.txt", "lamp\nmine\n");
    client.notify("workspace/didChangeWatchedFiles", folder.event("dotgen.toml", 2)).await;
    let again = json!({ "uri": uri, "apply": false });
    // Nobody sees the text before it is written.
    let unseen = client.ok(execute, command("dotgen.regenerate", json!({ "uri": uri }))).await;
    assert_eq!(unseen["status"], "failed");
    let messages = unseen["messages"].as_str().unwrap();
    assert!(messages.contains("exists and would be overwritten"), "{messages}");
    client.notification("window/showMessage").await;
    // Without a merge mode, and without a terminal: a change on both sides becomes a conflict.
    let merged = client.ok(execute, command("dotgen.regenerate", again.clone())).await;
    assert_eq!(merged["status"], "preview", "{merged}");
    assert_eq!(
        merged["files"][0]["after"],
        "lamp\n<<<<<<< user version\nmine\n=======\nTrue\n>>>>>>> template version\n"
    );
    let overwriting =
        json!({ "uri": uri, "template": "names", "arguments": ["-f"], "apply": false });
    let overwritten = client.ok(execute, command("dotgen.generate", overwriting)).await;
    assert_eq!(overwritten["files"][0]["after"], "lamp\nFalse\n");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn templates_of_dotgen_are_no_concern() {
    let (mut client, folder) = start(able(), true, &[]).await;
    let params = json!({ "uri": folder.uri("lamp.gen"), "template": "skeleton", "apply": false });
    let execute = "workspace/executeCommand";
    let plan = client.ok(execute, command("dotgen.generate", params)).await;
    let files = plan["files"].as_array().expect("a list");
    assert!(files.iter().any(|file| file["mode"] == 0o755), "{files:#?}");
    assert!(files.iter().all(|file| file["concern"].is_null()), "{files:#?}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn plain_clients_are_asked_before_anything_is_written() {
    let mut plain = able();
    plain["workspace"] = json!({});
    let (mut client, folder) = start(plain, true, &[]).await;
    let uri = folder.uri("lamp.gen");
    let execute = "workspace/executeCommand";
    client.answer("window/showMessageRequest", json!({ "title": "Cancel" }));
    let params = json!({ "uri": uri, "template": "names" });
    let done = client.ok(execute, command("dotgen.generate", params.clone())).await;
    assert_eq!(done["status"], "rejected");
    assert!(!folder.exists("lamp.txt"));
    client.answer("window/showMessageRequest", json!({ "title": "Write" }));
    let done = client.ok(execute, command("dotgen.generate", params)).await;
    assert_eq!(done["status"], "applied");
    assert_eq!(folder.read("lamp.txt"), "lamp\nFalse\n");
    let question = client.asked.last().unwrap();
    assert_eq!(question["params"]["message"], "names would create lamp.txt (executable).");
    // Without a template, the user may choose one from a list.
    client.answer("window/showMessageRequest", Value::Null);
    let done = client.ok(execute, command("dotgen.generate", json!({ "uri": uri }))).await;
    assert_eq!(done["status"], "cancelled");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_unknown_template_is_answered_with_the_setting() {
    let (mut client, folder) = start(able(), true, &[]).await;
    let params = json!({ "uri": folder.uri("lamp.gen"), "template": "nams", "apply": false });
    let execute = "workspace/executeCommand";
    let failed = client.ok(execute, command("dotgen.generate", params)).await;
    assert_eq!(failed["status"], "failed");
    let messages = failed["messages"].as_str().unwrap();
    for wanted in ["no template `nams`", "`names`", "`skeleton`", "`dotgen.templatePaths`"] {
        assert!(messages.contains(wanted), "{messages}");
    }
    assert!(!messages.contains("-t "), "{messages}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn untrusted_workspaces_run_nothing() {
    let (mut client, folder) = start(able(), false, &[]).await;
    let params = json!({ "uri": folder.uri("lamp.gen"), "template": "names" });
    let error = client
        .request("workspace/executeCommand", command("dotgen.generate", params))
        .await
        .unwrap_err();
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("not trusted"), "{message}");
    assert!(!folder.exists("lamp.txt"));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_failing_template_is_marked_where_it_fails() {
    let (mut client, folder) = start(able(), true, &[]).await;
    let source = folder.uri("templates/names/names.jinja");
    folder.write("templates/names/names.jinja", "a\n{{ component.name | nothing }}\n");
    let params = json!({ "uri": folder.uri("lamp.gen"), "template": "names", "apply": false });
    let execute = "workspace/executeCommand";
    let failed = client.ok(execute, command("dotgen.generate", params.clone())).await;
    assert_eq!(failed["status"], "failed");
    let pushed = client.pushed(&source).await;
    let diagnostic = &pushed["diagnostics"][0];
    assert_eq!(diagnostic["code"], "template-failed");
    assert_eq!(diagnostic["range"]["start"]["line"], 1);
    // After a successful run the diagnostic is gone.
    folder.write("templates/names/names.jinja", "a\n");
    client.ok(execute, command("dotgen.generate", params)).await;
    assert_eq!(client.pushed(&source).await["diagnostics"], json!([]));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn tcl_templates_run() {
    if let Err(reason) = dotgen_codegen::template::find_tclsh() {
        dotgen_loaders::skip(format_args!("{reason}"));
        return;
    }
    let (mut client, folder) = start(able(), true, &[
        ("templates/hello/template.tcl", "template usage {*}{\"Options:\\n  -x, --extra=WHAT\\tmore\\n\"}\ntemplate options { -x - --extra { set x [template arg] } -h - --help { puts [template usage]; exit 0 } }\ndotgen parse file {*}$argv\ntemplate parse args [list $x] file hello.txt file hello.txt\n"),
        ("templates/hello/hello.txt", "<'lassign $argv x'>\nhello <\"$x\"> <\"[[dotgen components] name]\">\n"),
        ("templates/bad/template.tcl", "dotgen parse file {*}$argv\ntemplate parse file bad.txt file bad.txt\n"),
        ("templates/bad/bad.txt", "one\n\n<\"[[dotgen components] nothing]\">\n"),
    ])
    .await;
    let uri = folder.uri("lamp.gen");
    let execute = "workspace/executeCommand";
    let asked = json!({ "uri": uri, "template": "hello" });
    let options = client.ok(execute, command("dotgen.templateOptions", asked)).await;
    assert_eq!(options["options"][0]["flags"], json!(["-x", "--extra"]));
    let params =
        json!({ "uri": uri, "template": "hello", "arguments": ["-x", "my"], "apply": false });
    let done = client.ok(execute, command("dotgen.generate", params)).await;
    assert_eq!(done["status"], "preview", "{done}");
    assert_eq!(done["files"][0]["after"], "\nhello my lamp\n");
    let params = json!({ "uri": uri, "template": "bad", "apply": false });
    client.ok(execute, command("dotgen.generate", params)).await;
    let pushed = client.pushed(&folder.uri("templates/bad/bad.txt")).await;
    assert_eq!(pushed["diagnostics"][0]["range"]["start"]["line"], 2, "{pushed}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_run_can_be_cancelled() {
    if let Err(reason) = dotgen_codegen::template::find_tclsh() {
        dotgen_loaders::skip(format_args!("{reason}"));
        return;
    }
    let mut capabilities = able();
    capabilities["window"] = json!({ "workDoneProgress": true });
    let loops = ("templates/loops/template.tcl", "while 1 {}\n");
    let (mut client, folder) = start(capabilities, true, &[loops]).await;
    let execute = "workspace/executeCommand";
    let uri = folder.uri("lamp.gen");
    // The list of files is complete first.
    while client.notification("$/progress").await["value"]["kind"] != "end" {}
    let params = json!({ "uri": uri, "template": "loops", "apply": false });
    let id = client.begin(execute, command("dotgen.generate", params)).await;
    let begun = client.notification("$/progress").await;
    assert_eq!(begun["value"]["cancellable"], true);
    let token = json!({ "token": begun["token"] });
    client.notify("window/workDoneProgress/cancel", token).await;
    assert_eq!(client.end(id).await.unwrap()["status"], "cancelled");
    assert_eq!(client.notification("$/progress").await["value"]["kind"], "end");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_action_is_at_the_component_and_on_request() {
    let (mut client, folder) = start(able(), true, &[]).await;
    let at = |line: u32, only: Value| {
        let mut params = document(&folder.uri("lamp.gen"));
        let place = json!({ "line": line, "character": 12 });
        params["range"] = json!({ "start": place, "end": place });
        params["context"] = json!({ "diagnostics": [], "only": only });
        params
    };
    let titles = |actions: &Value| -> Vec<String> {
        let all = actions.as_array().unwrap().iter();
        let all = all.filter(|action| action["command"]["command"].is_string());
        all.map(|action| action["title"].as_str().unwrap().to_owned()).collect()
    };
    let method = "textDocument/codeAction";
    let actions = client.ok(method, at(0, Value::Null)).await;
    assert_eq!(titles(&actions), ["Generate…"]);
    let actions = client.ok(method, at(3, Value::Null)).await;
    assert_eq!(titles(&actions), [""; 0]);
    let actions = client.ok(method, at(3, json!(["source"]))).await;
    assert_eq!(titles(&actions), ["Generate…"]);
    client.finish().await;
}
