template options { -f { set what [template arg] } }
template parse file $what file never.txt
