# Independent values for tests/uncertain.rs: mean and standard deviation of truncated laws, by mpmath at 30 digits from densities.
from mpmath import mp, mpf, quad, exp, log, sqrt, pi, inf, gamma
mp.dps = 30
normal = lambda m, s: (lambda x: exp(-((x-m)/s)**2/2))
logn = lambda mu, s: (lambda x: exp(-((log(x)-mu)/s)**2/2)/x)
cases = [
 ('normal', dict(mean='0.001', sd='0.0001', lower='0.0007', upper='0.0013'), normal(mpf('0.001'), mpf('0.0001')), '0.0007', '0.0013'),
 ('normal', dict(mean='0', sd='1', lower='9', upper='10'), normal(0, 1), '9', '10'),
 ('lognormal', dict(median='2', cv='0.5', lower='1', upper='3'), logn(log(2), sqrt(log(mpf('1.25')))), '1', '3'),
 ('gamma', dict(shape='0.5', scale='2', lower='0.1', upper='4'), lambda x: x**(-mpf('0.5'))*exp(-x/2), '0.1', '4'),
 ('weibull', dict(shape='1.5', scale='3', upper='2'), lambda x: x**mpf('0.5')*exp(-(x/3)**mpf('1.5')), '0', '2'),
 ('gumbel', dict(location='1', scale='2', lower='0', upper='8'), lambda x: exp(-(x-1)/2-exp(-(x-1)/2)), '0', '8'),
 ('exponential', dict(mean='2', lower='1', upper='5'), lambda x: exp(-x/2), '1', '5'),
 ('beta', dict(a='2', b='5', lower='1', upper='3'), lambda x: (x-1)*(3-x)**4, '1', '3'),
 ('log-uniform', dict(lower='0.01', upper='10'), lambda x: 1/x, '0.01', '10'),
 ('triangular', dict(lower='0', mode='3', upper='10'), None, '0', '10'),
]
print('# made by moments.py: distribution;keys;mean;sd')
for name, keys, f, lo, hi in cases:
    if f is None:
        mean, var = mpf(13)/3, (mpf(100)+9-30)/18
    else:
        pts = [mpf(lo) + (mpf(hi)-mpf(lo))*k/16 for k in range(17)]
        z = quad(f, pts); mean = quad(lambda x: x*f(x), pts)/z; var = quad(lambda x: (x-mean)**2*f(x), pts)/z
    print(name, ' '.join(f'{k}={v}' for k, v in keys.items()), mp.nstr(mean, 20), mp.nstr(sqrt(var), 20), sep=';', flush=True)
