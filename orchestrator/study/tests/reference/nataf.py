# Independent values for tests/correlation.rs: rho = Corr(x1(z1), x2(z2)) of correlated standard normals, by direct two-dimensional
# quadrature: z1 by Gauss-Legendre panels (cut at the mode of the triangular law), w by the trapezoidal rule, z2 = r z1 + s w.
import numpy as np
from scipy import stats, special as sp
def tails(z): return sp.ndtr(z), sp.ndtr(-z)
def plain(d):
    def f(z):
        z = np.asarray(z); out = np.empty(z.shape); m = z <= 0
        out[m] = d.ppf(sp.ndtr(z[m])); out[~m] = d.isf(sp.ndtr(-z[~m])); return out
    return f
def cut(d, lo, hi):
    pl = d.cdf(lo); qh = d.sf(hi) if np.isfinite(hi) else 0.0
    Z = 1 - pl - qh
    def f(z):
        z = np.asarray(z); p, q = tails(z); P = pl + p*Z; Q = qh + q*Z
        out = np.where(P <= 0.5, d.ppf(np.minimum(P, .6)), d.isf(np.minimum(Q, .6)))
        return np.clip(out, lo, hi)
    return f
laws = {
 'normal 0 1': plain(stats.norm()), 'uniform 0 1': plain(stats.uniform()), 'exponential 1': plain(stats.expon()),
 'gamma 0.5 1': plain(stats.gamma(.5)), 'gumbel 0 1': plain(stats.gumbel_r()), 'weibull 1.5 1': plain(stats.weibull_min(1.5)),
 'beta 2 5 0 1': plain(stats.beta(2,5)), 'beta 0.5 0.5 0 1': plain(stats.beta(.5,.5)),
 'lognormal 0 1.5': lambda z: np.exp(1.5*np.asarray(z)), 'triangular 0 1 4': plain(stats.triang(.25, 0, 4)),
 'normal 0 1 cut -0.5 3': cut(stats.norm(), -.5, 3.), 'exponential 1 cut 0.2 2': cut(stats.expon(), .2, 2.),
}
x, w = np.polynomial.legendre.leggauss(24)
def panels(cutz):
    edges = sorted(set(list(np.arange(-13, 15.01, 0.25)) + ([cutz] if cutz is not None else [])))
    zs, ws = [], []
    for a, b in zip(edges, edges[1:]):
        zs.append((a+b)/2 + (b-a)/2*x); ws.append((b-a)/2*w)
    return np.concatenate(zs), np.concatenate(ws)
phi = lambda z: np.exp(-z*z/2)/np.sqrt(2*np.pi)
def stat(f, cutz):
    z, wt = panels(cutz); v = f(z); g = wt*phi(z); m = (g*v).sum(); return m, np.sqrt((g*(v-m)**2).sum())
kink = {'triangular 0 1 4': sp.ndtri(.25)}
def rho(n1, n2, r):
    if n2 in kink: n1, n2 = n2, n1
    assert n2 not in kink
    f1, f2 = laws[n1], laws[n2]
    m1, s1 = stat(f1, kink.get(n1)); m2, s2 = stat(f2, None)
    z, wt = panels(kink.get(n1)); g = wt*phi(z)*(f1(z)-m1)/s1
    keep = np.abs(g) > 1e-22; z, g = z[keep], g[keep]
    h = 0.04; t = np.arange(-10, 10+h/2, h); gw = h*phi(t); s = np.sqrt(1-r*r)
    tot = 0.0
    for i in range(0, len(z), 200):
        zz = r*z[i:i+200,None] + s*t[None,:]
        tot += (g[i:i+200,None]*gw[None,:]*(f2(zz)-m2)/s2).sum()
    return tot
pairs = [('exponential 1','exponential 1'),('gamma 0.5 1','normal 0 1'),('gamma 0.5 1','gumbel 0 1'),('normal 0 1 cut -0.5 3','weibull 1.5 1'),
 ('triangular 0 1 4','beta 2 5 0 1'),('exponential 1 cut 0.2 2','exponential 1'),('beta 0.5 0.5 0 1','uniform 0 1'),('lognormal 0 1.5','gumbel 0 1'),('lognormal 0 1.5','lognormal 0 1.5'),('uniform 0 1','uniform 0 1')]
print('# made by nataf.py: first;second;correlation of the normals;linear correlation')
for a, b in pairs:
    for r in (-0.9, -0.4, 0.3, 0.7, 0.95):
        print(f'{a};{b};{r};{float(rho(a,b,r))!r}', flush=True)
