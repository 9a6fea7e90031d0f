N = 15 / 3
print "a module of Python 2"
N *= 2
