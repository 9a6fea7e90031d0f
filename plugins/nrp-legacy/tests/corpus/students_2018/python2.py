import string, sys
reload(sys)
sys.setdefaultencoding('utf8')
from itertools import izip
import cPickle, Queue, StringIO, lab.sizes
from lab.sizes import N


class Lost(Exception):
    pass


def lose():
    raise Lost, "it"  # by the way, raise E, "x"

try:
    lose()
except Lost, e:
    print >>sys.stderr, "lost", e
names = {'b': 1, 'a': 2}
keys = names.keys()
keys.sort()
exec "z = 3"
exec "y = 4" in names
assert keys == ['a', 'b'] and names.has_key('y') and z == 3 and `z` <> '4' and N == 10
assert map(lambda x: x + 1, [1, 2])[0] + filter(None, [0, 1])[0] + zip([1], [2])[0][1] == 5
assert range(2) + [2L] == [0, 1, 0777 - 509] and sorted([1, 2], cmp=lambda a, b: b - a) == [2, 1]
assert string.letters[0] == 'a' and isinstance(u'', basestring) and iter([1]).next() == 1


@nrp.MapCSVRecorder("rows", filename="python2.csv", headers=["t", "half"])
@nrp.Robot2Neuron()
def python2(t, rows):
	half = len(names) / 2
	half /= 1
        rows.record_entry(t, [5, 6, 7][half])
