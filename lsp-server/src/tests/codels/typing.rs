//! While a specification is being typed, what was known of its codels stays.

use super::*;

/// Where the tokens of a text begin.
fn tokens(text: &str) -> Vec<usize> {
    let is_word = |it: char| it.is_alphanumeric() || it == '_';
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

#[tokio::test(flavor = "multi_thread")]
async fn a_text_that_breaks_off_anywhere_keeps_lenses_implementations_and_findings() {
    const EARLIER: &str = " · as of the last text without syntax errors";
    let folder = tank();
    // The codels of this file are missing, which shows in the specification.
    folder.write("codels/tank_codels.c", "");
    let (uri, source) = (
        folder.uri("tank.gen"),
        folder.uri("codels/tank_control_codels.c"),
    );
    let (text, code) = (read(path(&uri)), read(path(&source)));
    let mut client = Client::start(folder.params(pulling())).await;
    client.open(&uri, &text).await;
    client.open_code(&source, &code).await;
    let titles = |lenses: &Value| -> Vec<String> {
        let all = lenses.as_array().expect("a list").iter();
        all.map(|it| {
            it["command"]["title"]
                .as_str()
                .unwrap_or_default()
                .to_owned()
        })
        .collect()
    };
    let lenses = titles(&client.ok("textDocument/codeLens", document(&source)).await);
    assert!(lenses.len() > 3);
    let drift = |report: &Value| -> Vec<String> {
        let all = messages(&report["items"]).into_iter();
        all.filter(|it| it.starts_with("codel/")).collect()
    };
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    let findings = drift(&report);
    assert!(findings.len() > 3, "{findings:?}");
    let mut version = 1;
    let mut earlier = 0;
    for cut in tokens(&text).into_iter().step_by(2) {
        // The text is whole before it breaks off.
        version += 2;
        client
            .change(&uri, version - 1, json!([{ "text": text }]))
            .await;
        let whole = titles(&client.ok("textDocument/codeLens", document(&source)).await);
        assert_eq!(whole, lenses);
        client
            .change(&uri, version, json!([{ "text": &text[..cut] }]))
            .await;
        let now = titles(&client.ok("textDocument/codeLens", document(&source)).await);
        let plain: Vec<_> = now
            .iter()
            .map(|it| it.trim_end_matches(EARLIER).to_owned())
            .collect();
        // A text that ends between declarations is a whole one, which has fewer.
        if now.iter().all(|it| !it.ends_with(EARLIER)) {
            continue;
        }
        earlier += 1;
        assert_eq!(plain, lenses, "at {cut}");
        let report = client.ok("textDocument/diagnostic", document(&uri)).await;
        let left = drift(&report);
        // The last codel that is named is the one that is cut; what is behind it has no place to be shown.
        let whole = text[..cut].rfind("codel").map_or("", |it| &text[..it]);
        for message in &findings {
            let named = message.split('`').skip(1).step_by(2);
            let mut codels = named.filter(|it| it.starts_with("tank_"));
            let is_whole = codels
                .next()
                .is_some_and(|it| whole.contains(&format!("{it}(")));
            assert!(
                left.contains(message) || !is_whole,
                "at {cut}: {message}\n{left:#?}"
            );
        }
        if whole.contains("tank_control_main") {
            let params = at(&uri, &text, "tank_control_main", 0);
            let found = client.ok("textDocument/implementation", params).await;
            assert!(found.is_array(), "at {cut}: {found}");
        }
    }
    assert!(earlier > 50, "{earlier}");
    client
        .finish_ignoring("textDocument/publishDiagnostics")
        .await;
}
