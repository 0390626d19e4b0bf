# Places of all members.
dotgen parse file {*}$argv
foreach t [dotgen types] {
  if {[$t kind] eq "struct member"} { puts "[$t name] [lrange [$t loc] 1 end]" }
}
