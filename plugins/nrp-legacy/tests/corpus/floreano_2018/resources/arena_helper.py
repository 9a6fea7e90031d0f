from numpy import mean
SCALE = 2
