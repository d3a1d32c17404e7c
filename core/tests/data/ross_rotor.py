"""The rotor of ross_rotor.machine.toml in ROSS 2.3.0, saved by it as ross_rotor.toml."""

import sys

import ross as rs

STEEL = rs.Material("steel", rho=7810, E=211e9, G_s=81.2e9)
SOFT = rs.Material("sleeve", rho=7000, E=6894.75, G_s=6894.75)


def rotor():
    # length, then inner and outer diameter at the left and at the right end
    sections = [
        (0.1, 0, 0.08, 0, 0.08),
        (0.1, 0, 0.08, 0, 0.08),
        (0.2, 0, 0.08, 0, 0.12),
        (0.2, 0.02, 0.12, 0.04, 0.12),
        (0.15, 0.02, 0.12, 0.02, 0.07),
        (0.15, 0, 0.07, 0, 0.07),
    ]
    layers = [(3, STEEL, 0.2, 0.12, 0.16, 0.12, 0.16), (3, SOFT, 0.2, 0.12, 0.13, 0.12, 0.18), (1, STEEL, 0.1, 0.08, 0.1, 0.08, 0.1)]
    parts = [(n, STEEL, *section) for n, section in enumerate(sections)] + layers
    shaft = [
        rs.ShaftElement(n=n, material=material, L=length, idl=idl, odl=odl, idr=idr, odr=odr)
        for n, material, length, idl, odl, idr, odr in parts
    ]
    discs = [
        rs.DiskElement(n=2, m=25.0, Id=0.15, Ip=0.28, tag="Disk A"),
        rs.DiskElement(n=4, m=12, Id=0, Ip=0),
    ]
    bearings = [
        rs.BearingElement(n=0, kxx=5e7, kyy=7e7, cxx=2e4, cyy=3e4, kxy=1e6, kyx=-1e6, tag="Bearing 0"),
        rs.BearingElement(
            n=6,
            n_link=7,
            frequency=[0, 200, 500, 1200],
            kxx=[4e7, 5e7, 6e7, 7e7],
            kyy=[5e7, 6e7, 6.5e7, 7e7],
            kxy=[1e6, 2e6, 3e6, 4e6],
            kyx=[-1e6, -2e6, -3e6, -4e6],
            cxx=[3e4, 2e4, 1.5e4, 1e4],
        ),
        rs.BearingElement(n=7, kxx=5e8, kyy=8e8, cxx=1e4, cyy=2e4),
        rs.SealElement(n=3, kxx=1e5, kyy=1e5, kxy=2e6, kyx=-2e6, cxx=500, cyy=500),
    ]
    masses = [rs.PointMass(n=7, mx=40, my=50, mz=45)]
    return rs.Rotor(shaft, discs, bearings, masses, rated_w=600.0)


if __name__ == "__main__":
    rotor().save("ross_rotor.toml")
    for speed in [0.0, 200.0, 500.0]:
        modes = rotor().run_modal(speed, num_modes=40, sparse=False)
        print(speed, modes.wd.tolist(), modes.log_dec.tolist(), file=sys.stdout)
