# Checks quantiles.csv (for the tests of probability/ and of uncertain parameters) by mpmath at 60 digits: the step of Newton's method
# that each of its values is away from its probability (of the double nearest to it), in the tail that is smaller. Prints the largest;
# with the argument `write`, the values are moved by their steps.
import os, sys
from mpmath import mp, mpf, log, exp, sqrt, pi, erfc, gammainc, nstr
mp.dps = 60
NUMBERS = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'quantiles.csv')

def tail(kind, a, x, lower):
    """The probability below x (or above it), and the density."""
    if kind == 'normal':
        z = (x - a[0])/a[1]
        return erfc((-z if lower else z)/sqrt(2))/2, exp(-z*z/2)/sqrt(2*pi)/a[1]
    if kind == 'lognormal':
        part, density = tail('normal', a, log(x), lower)
        return part, density/x
    if kind == 'uniform': return ((x - a[0]) if lower else (a[1] - x))/(a[1] - a[0]), 1/(a[1] - a[0])
    if kind == 'exponential': return (-mp.expm1(-a[0]*x) if lower else exp(-a[0]*x)), a[0]*exp(-a[0]*x)
    if kind == 'weibull':
        hazard = (x/a[1])**a[0]
        return (-mp.expm1(-hazard) if lower else exp(-hazard)), a[0]*hazard/x*exp(-hazard)
    if kind == 'gumbel':
        inner = exp(-(x - a[0])/a[1])
        return (exp(-inner) if lower else -mp.expm1(-inner)), inner*exp(-inner)/a[1]
    if kind == 'triangular':
        low, high, mode = a
        if x <= mode:
            part, density = (x - low)**2/((high - low)*(mode - low)), 2*(x - low)/((high - low)*(mode - low))
            return (part if lower else 1 - part), density
        part, density = (high - x)**2/((high - low)*(high - mode)), 2*(high - x)/((high - low)*(high - mode))
        return (1 - part if lower else part), density
    if kind == 'gamma':
        part = gammainc(a[0], 0, x, regularized=True) if lower else gammainc(a[0], x, regularized=True)
        return part, exp((a[0] - 1)*log(x) - x - mp.loggamma(a[0]))
    if kind == 'beta':
        ln_beta = mp.loggamma(a[0]) + mp.loggamma(a[1]) - mp.loggamma(a[0] + a[1])
        density = exp((a[0] - 1)*log(x) + (a[1] - 1)*log(1 - x) - ln_beta)
        # x (1 - x) density/first 2F1(first + second, 1; first + 1; y): all terms are positive
        first, y = (a[0], x) if lower else (a[1], 1 - x)
        term = total = mpf(1)
        k = 0
        while term > total*mpf('1e-50'):
            term *= (a[0] + a[1] + k)/(first + 1 + k)*y
            total += term
            k += 1
        return x*(1 - x)*density/first*total, density
    raise ValueError(kind)

lines, worst, count = open(NUMBERS).read().splitlines(), mpf(0), 0
for number, line in enumerate(lines):
    cells = line.split(';')
    if line.startswith('#') or cells[0] == 'distribution': continue
    a, p, x = [mpf(float(word)) for word in cells[1].split(' ')], mpf(float(cells[2])), mpf(cells[3])
    lower = p <= mpf(1)/2
    # at an end, to all digits that are written: there is no step
    if cells[0] == 'beta' and x == 1 or cells[0] in ('uniform', 'triangular') and x in (a[0], a[1]):
        print('at an end:', line)
        continue
    part, density = tail(cells[0], a, x, lower)
    step = ((p - part) if lower else (part - (1 - p)))/density
    off = abs(step/x) if x else abs(step)
    worst, count = max(worst, off), count + 1
    if off > mpf('1e-23'): print(line, nstr(off, 3), flush=True)
    lines[number] = ';'.join(cells[:3] + [nstr(x + step, 25)])
print(count, 'values, largest step', nstr(worst, 3))
if 'write' in sys.argv: open(NUMBERS, 'w').write('\n'.join(lines) + '\n')
