//! `energy_lanes`: which systems have it, and what its loop computes.



#[test]
fn dbg() {
    let out = crate::expand(&quote::quote!(midpoint), &quote::quote!(impl Charges {
    pub fn lagrangian(&self, q: [[f64; 3]; 2], v: [[f64; 3]; 2]) -> f64 {
        let mut l = 0.0;
        let mut distance = 0.3;
        for k in 0..3 {
            distance += (q[1][k] - q[0][k]).powi(2);
        }
        for i in 0..2 {
            for k in 0..3 {
                l += 0.5 * self.m[i] * v[i][k].powi(2);
            }
            l += 0.5 * self.b * (q[i][0] * v[i][1] - q[i][1] * v[i][0]);
        }
        l + distance.sqrt().recip()
    }
    }), crate::Settings::default()).to_string();
    let at = out.find("fn energy_lanes").unwrap();
    panic!("{}", &out[at..at + 3000]);
}
