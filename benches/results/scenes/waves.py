"""The wave on each film against the linear stability of a front. python3 waves.py OUT..."""
import glob, json, math, sys
import numpy as np
W, TOP = 20.0, 14.0
K = 2 * math.pi / W
def front(lam, d, s=1.0, k=K):
    """Speed of a flat front and the rate at which a wave of the wave number k grows, at the depth d."""
    H = TOP - d
    T = math.tanh(d / lam)
    cs = 1 / (1 + H / lam * T)
    V = s * cs * lam * T
    q = math.sqrt(k * k + 1 / lam**2)
    A = -(cs / lam**2) / (k / math.tanh(k * H) + q * math.tanh(q * d))
    return V, s * cs - V * k * math.tanh(k * d) + s * lam**2 * A * (q * math.tanh(q * d) - k * math.tanh(k * d)), cs
def surface(p, axis, length, diam, bins=40):
    """The highest point of cells over each of the bins along x."""
    h = np.zeros(bins); xs = (np.arange(bins) + .5) * W / bins - W / 2
    half = .5 * (length - diam)
    for t in np.linspace(-1, 1, 9):
        c = p + t * half[:, None] * axis
        for i, x in enumerate(xs):
            dx = (c[:, 0] - x + W / 2) % W - W / 2
            ok = np.abs(dx) < diam / 2
            if ok.any(): h[i] = max(h[i], (c[ok, 1] + np.sqrt((diam[ok] / 2)**2 - dx[ok]**2)).max())
    return xs, h
def read(path):
    d = np.load(path); q = d["orientation"]
    w, x, y, z = q.T
    axis = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], 1)
    return json.loads(bytes(d["header"]).decode())["time"], d["position"], axis, d["size"][:, 1], d["size"][:, 0]
for folder in sys.argv[1:]:
    scene = json.load(open(folder + "/scene.json")); food = scene["fields"]["food"]
    D, dt = food["diffusion"], scene["time"]["dt"]; u = food["exchange"][0]["uptake"] / 15
    rows = []
    for path in sorted(glob.glob(folder + "/states/*.npz")):
        t, p, axis, L, d = read(path)
        xs, h = surface(p, axis, L, d)
        area = (math.pi * d**2 / 4 + (L - d) * d)
        mean = h.mean(); low = p[:, 1] < mean - 2
        phi = area[low].sum() / (W * (mean - 2))
        rows.append((t, mean, 2 * (h * np.cos(K * xs)).mean(), 2 * (h * np.sin(K * xs)).mean(), phi, len(p), area.sum()))
    r = np.array(rows)
    phi = r[len(r) // 3:, 4].mean()
    lam = math.sqrt(D * (1 / (u * phi) + dt))
    # From where the field is that of a steady front.
    start = np.argmax(r[:, 0] > 1.2 * TOP**2 / D / 2)
    end = np.argmax(r[:, 1] > 11) or len(r) - 1
    a0, logs = r[start, 2], 0.0
    V = []
    for i in range(start, end):
        d = .5 * (r[i, 1] + r[i + 1, 1]); v, sigma, cs = front(lam, d)
        logs += sigma / v * (r[i + 1, 1] - r[i, 1]); V.append(v)
    moved, time = r[end, 1] - r[start, 1], r[end, 0] - r[start, 0]
    print(f"{folder}: lambda {lam:.2f} phi {phi:.3f} cells {int(r[start,5])}-{int(r[end,5])} t {r[start,0]:.1f}-{r[end,0]:.1f} depth {r[start,1]:.2f}-{r[end,1]:.2f} "
      f"speed {moved/time:.4f} closed {np.mean(V):.4f} ratio {moved/time/np.mean(V):.3f}; wave {a0:.2f}->{r[end,2]:.2f} (sin {r[end,3]:.2f}) factor {r[end,2]/a0:.2f} closed {math.exp(logs):.2f}")
