# Writes files in the modes of the engine.
template options { -C { engine chdir [template arg] } -m { engine merge-tool [template arg]; engine mode +merge-if-change } }
template parse raw "one\ntwo\n" file a/one.txt
template parse raw "one\ntwo\n" file a/one.txt
template parse perm a+x string "#!/bin/sh\n<\"echo [dotgen template name]\">\n" file run.sh
if {[catch {template parse raw "changed\n" file a/one.txt} message]} { puts "refused: [lindex [split $message \n] 0]" }
engine mode +overwrite -move-if-change
template parse raw "changed\n" file a/one.txt
puts "deps [lmap f [template deps] {file tail $f}]"
