# Prints what the object commands tell about a specification.
template usage "report: prints a specification\n"
set lang c
template options {
  -l - --language { set lang [template arg] }
  -h - --help { puts [template usage]; exit 0 }
}
dotgen parse file {*}$argv
template parse args [list $lang] file report.txt string text
puts -nonewline $text
puts "notice {[dotgen input notice]}"
puts "types [llength [dotgen types]], named [llength [dotgen types ::*]]"
puts "abbreviated [[dotgen component] name]"
foreach c [dotgen components] {
  puts "wanted [lmap t [$c types public {o {expr {[$o class] ne {type} || [$o kind] ne {double}}}}] {$t mangle}]"
}
