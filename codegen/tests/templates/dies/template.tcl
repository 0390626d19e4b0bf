exec kill -9 [pid]
