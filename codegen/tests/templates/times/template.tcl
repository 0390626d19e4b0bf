# Times of all codels and tasks.
dotgen parse file {*}$argv
foreach c [dotgen components] {
  foreach t [$c tasks] {
    puts "[$t name] [$t period]"
    foreach k [$t codels] { puts "[$k name] [$k wcet]" }
  }
}
