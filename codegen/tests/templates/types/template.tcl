# Kinds, names and lines of all named types, in order.
dotgen parse file {*}$argv
foreach t [dotgen types] {
  if {![catch {$t fullname} name]} { puts "[$t kind] $name [lindex [$t loc] 1]" }
}
