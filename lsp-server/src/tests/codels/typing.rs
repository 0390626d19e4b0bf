//! While the user types in a specification, the findings about its codels remain.

use super::*;

/// The starts of the tokens of a text.
fn tokens(text: &str) -> Vec<usize> {
    let is_word = |character: char| character.is_alphanumeric() || character == '_';
    let mut out = Vec::new();
    let mut before = ' ';
    for (at, now) in text.char_indices() {
        let inside = is_word(now) && is_word(before);
        if !now.is_whitespace() && !inside {
            out.push(at);
        }
        before = now;
    }
    out
}

/// The findings about codels in documents.
async fn drift(client: &mut Client, documents: &[String]) -> Vec<String> {
    let mut out = Vec::new();
    for uri in documents {
        let report = client.ok("textDocument/diagnostic", document(uri)).await;
        out.extend(messages(&report["items"]));
    }
    out.retain(|message| message.starts_with("codel/"));
    out
}

#[tokio::test(flavor = "multi_thread")]
async fn a_text_that_breaks_off_anywhere_keeps_lenses_implementations_and_findings() {
    const EARLIER: &str = " · as of the last text without syntax errors";
    let folder = tank();
    let (uri, source) = (folder.uri("tank.gen"), folder.uri("codels/tank_control_codels.c"));
    let (text, code) = (read(path(&uri)), read(path(&source)));
    let mut params = folder.params(pulling());
    params["initializationOptions"] = json!({ "pullSources": true });
    let mut client = Client::start(params).await;
    client.open(&uri, &text).await;
    client.open_code(&source, &code).await;
    let titles = |lenses: &Value| -> Vec<String> {
        let all = lenses.as_array().expect("a list").iter();
        all.map(|lens| lens["command"]["title"].as_str().unwrap_or_default().to_owned()).collect()
    };
    let lenses = titles(&client.ok("textDocument/codeLens", document(&source)).await);
    assert!(lenses.len() > 3);
    let places = FILES.map(|name| folder.uri(name));
    let findings = drift(&mut client, &places).await;
    assert!(findings.len() > 3, "{findings:?}");
    let mut version = 1;
    let mut earlier = 0;
    for cut in tokens(&text).into_iter().step_by(2) {
        // The text is complete before it is cut.
        version += 2;
        client.change(&uri, version - 1, json!([{ "text": text }])).await;
        let whole = titles(&client.ok("textDocument/codeLens", document(&source)).await);
        assert_eq!(whole, lenses);
        client.change(&uri, version, json!([{ "text": &text[..cut] }])).await;
        let now = titles(&client.ok("textDocument/codeLens", document(&source)).await);
        let plain: Vec<_> =
            now.iter().map(|title| title.trim_end_matches(EARLIER).to_owned()).collect();
        // A text that ends between two declarations is complete, with fewer declarations.
        if now.iter().all(|title| !title.ends_with(EARLIER)) {
            continue;
        }
        earlier += 1;
        assert_eq!(plain, lenses, "at {cut}");
        let left = drift(&mut client, &places).await;
        // The last codel name may be cut; names after it have no place for a finding.
        let whole = text[..cut].rfind("codel").map_or("", |end| &text[..end]);
        for message in &findings {
            let named = message.split('`').skip(1).step_by(2);
            let mut codels = named.filter(|part| part.starts_with("tank_"));
            let is_whole = codels.next().is_some_and(|codel| whole.contains(&format!("{codel}(")));
            assert!(left.contains(message) || !is_whole, "at {cut}: {message}\n{left:#?}");
        }
        if whole.contains("tank_mix") {
            let params = at(&uri, &text, "tank_mix", 0);
            let found = client.ok("textDocument/implementation", params).await;
            assert!(found.is_array(), "at {cut}: {found}");
        }
    }
    assert!(earlier > 50, "{earlier}");
    client.finish_ignoring("textDocument/publishDiagnostics").await;
}
