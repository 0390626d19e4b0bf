# Places of the default values of parameters.
dotgen parse file {*}$argv
foreach s [[dotgen component] services] {
  foreach p [$s parameters] { puts "[$p name] [lrange [[$p initializer] loc] 1 end]" }
}
