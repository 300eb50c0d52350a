//! What a part costs and how long one waits for it, as its maker or a shop says it.
//!
//! The one idea: motors, gears and modules are bought alike, so that there is one [`Offer`], which is a part of each kind of
//! row. A price is one number with its currency and its day: without them it is no price.

use std::fmt;

use super::wrong::Wrong;
use crate::words::nearest;

/// A currency by its code of ISO 4217.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Currency(&'static str);

/// Codes of ISO 4217, those of coins and notes.
const CURRENCIES: &[&str] = &[
    "AED", "AFN", "ALL", "AMD", "ANG", "AOA", "ARS", "AUD", "AWG", "AZN", "BAM", "BBD", "BDT", "BGN", "BHD", "BIF",
    "BMD", "BND", "BOB", "BRL", "BSD", "BTN", "BWP", "BYN", "BZD", "CAD", "CDF", "CHF", "CLP", "CNY", "COP", "CRC",
    "CUP", "CVE", "CZK", "DJF", "DKK", "DOP", "DZD", "EGP", "ERN", "ETB", "EUR", "FJD", "FKP", "GBP", "GEL", "GHS",
    "GIP", "GMD", "GNF", "GTQ", "GYD", "HKD", "HNL", "HTG", "HUF", "IDR", "ILS", "INR", "IQD", "IRR", "ISK", "JMD",
    "JOD", "JPY", "KES", "KGS", "KHR", "KMF", "KPW", "KRW", "KWD", "KYD", "KZT", "LAK", "LBP", "LKR", "LRD", "LSL",
    "LYD", "MAD", "MDL", "MGA", "MKD", "MMK", "MNT", "MOP", "MRU", "MUR", "MVR", "MWK", "MXN", "MYR", "MZN", "NAD",
    "NGN", "NIO", "NOK", "NPR", "NZD", "OMR", "PAB", "PEN", "PGK", "PHP", "PKR", "PLN", "PYG", "QAR", "RON", "RSD",
    "RUB", "RWF", "SAR", "SBD", "SCR", "SDG", "SEK", "SGD", "SHP", "SLE", "SOS", "SRD", "SSP", "STN", "SVC", "SYP",
    "SZL", "THB", "TJS", "TMT", "TND", "TOP", "TRY", "TTD", "TWD", "TZS", "UAH", "UGX", "USD", "UYU", "UZS", "VES",
    "VND", "VUV", "WST", "XAF", "XCD", "XCG", "XOF", "XPF", "YER", "ZAR", "ZMW", "ZWG",
];

impl Currency {
    /// The currency of a code.
    ///
    /// # Errors
    /// What to write instead.
    ///
    /// ```
    /// use gearwise_model::catalog::Currency;
    /// assert_eq!(Currency::of("EUR").unwrap().code(), "EUR");
    /// assert!(Currency::of("eur").unwrap_err().contains("did you mean `EUR`"));
    /// assert!(Currency::of("RMB").unwrap_err().contains("CNY"));
    /// ```
    pub fn of(code: &str) -> Result<Currency, String> {
        if let Some(known) = CURRENCIES.iter().find(|known| **known == code) {
            return Ok(Currency(known));
        }
        let upper = code.to_uppercase();
        // A unit is no slip of a code.
        let near = match CURRENCIES.contains(&upper.as_str()) {
            true => Some(upper.as_str()),
            false if code == upper && code.len() >= 3 => nearest(&upper, CURRENCIES.iter().copied()),
            false => None,
        };
        let near = near.map_or_else(String::new, |near| format!("did you mean `{near}`? "));
        Err(format!("{near}it is a code of ISO 4217: EUR, USD, GBP, CHF, CNY, JPY, KRW and so on"))
    }

    /// Its code.
    pub fn code(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for Currency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// A day of the calendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date {
    year: u16,
    month: u8,
    day: u8,
}

impl Date {
    /// A day, as `2026-11-01`.
    ///
    /// # Errors
    /// What to write instead.
    ///
    /// ```
    /// use gearwise_model::catalog::Date;
    /// assert_eq!(Date::read("2028-02-29").unwrap().to_string(), "2028-02-29");
    /// assert!(Date::read("01-11-2026").unwrap_err().contains("2026-11-01"));
    /// assert!(Date::read("2027-02-29").is_err());
    /// ```
    pub fn read(text: &str) -> Result<Date, String> {
        let plain = || "write year, month and day, as 2026-11-01".to_string();
        let parts: Vec<&str> = text.split(['-', '.', '/']).collect();
        let digits = |part: &&str| !part.is_empty() && part.len() <= 4 && part.bytes().all(|b| b.is_ascii_digit());
        let &[first, second, third] = parts.as_slice() else { return Err(plain()) };
        if !parts.iter().all(digits) {
            return Err(plain());
        }
        if first.len() <= 2 && third.len() == 4 {
            // Which of the two is the month nobody knows, unless one cannot be.
            let day_first = Date::read(&format!("{third}-{second:0>2}-{first:0>2}")).ok();
            let month_first = Date::read(&format!("{third}-{first:0>2}-{second:0>2}")).ok();
            return Err(match (day_first, month_first) {
                (Some(a), Some(b)) if a != b => format!("the year comes first: write {a} or {b}"),
                (Some(date), _) | (None, Some(date)) => format!("the year comes first: write {date}"),
                (None, None) => plain(),
            });
        }
        let is_plain = text.matches('-').count() == 2 && [first.len(), second.len(), third.len()] == [4, 2, 2];
        let number = |part: &str| part.parse::<u16>().ok();
        let (Some(year), Some(month), Some(day), true) = (number(first), number(second), number(third), is_plain)
        else {
            return Err(plain());
        };
        let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let days = match month {
            2 if leap => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => return Err(format!("there is no month {month}: {}", plain())),
        };
        if day == 0 || day > days {
            return Err(format!("that month has {days} days"));
        }
        Ok(Date { year, month: month as u8, day: day as u8 })
    }

    /// Whether a text is a day, a month or a year: `2026-11-01`, `2026-11`, `2026`.
    ///
    /// # Errors
    /// What to write instead.
    ///
    /// ```
    /// use gearwise_model::catalog::Date;
    /// assert!(["2026", "2026-11", "2026-11-01"].iter().all(|text| Date::check_partly(text).is_ok()));
    /// assert!(["26", "2026-13", "2026-1", "May 2026", "2026-11-31"].iter().all(|text| Date::check_partly(text).is_err()));
    /// ```
    pub fn check_partly(text: &str) -> Result<(), String> {
        let rest = match text.len() {
            4 => "-01-01",
            7 => "-01",
            _ => "",
        };
        if text.get(..4).and_then(|year| year.parse::<u16>().ok()).is_some_and(|year| !(1900..2100).contains(&year)) {
            return Err("a year is one of this century or the last".into());
        }
        let help = |why: String| if rest.is_empty() { format!("{why}, or 2026-11, or 2026") } else { why };
        Date::read(&format!("{text}{rest}")).map(drop).map_err(help)
    }

    /// Whether two days are no more than so many years apart.
    ///
    /// ```
    /// use gearwise_model::catalog::Date;
    /// let [a, b, c] = ["2024-11-01", "2026-11-01", "2026-11-02"].map(|day| Date::read(day).unwrap());
    /// assert!(a.is_within(2, b) && b.is_within(2, a) && !a.is_within(2, c));
    /// ```
    pub fn is_within(self, years: u16, other: Date) -> bool {
        let (early, late) = if self <= other { (self, other) } else { (other, self) };
        Date { year: early.year.saturating_add(years), ..early } >= late
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

/// What a row says of buying its part.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Offer {
    /// Price of one, in its currency.
    pub price: Option<f64>,
    /// So many have to be bought at once for that price; one where nothing is said.
    pub price_quantity: Option<f64>,
    /// Its currency; empty where nothing is said.
    pub price_currency: String,
    /// Its day; empty where nothing is said.
    pub price_date: String,
    /// Time until it is delivered \[s\].
    pub lead_time: Option<f64>,
}

/// A price with what makes it one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Price {
    /// Of one.
    pub value: f64,
    /// Its currency.
    pub currency: Currency,
    /// Its day.
    pub date: Date,
    /// So many have to be bought at once for it.
    pub quantity: f64,
}

/// What has an offer: the numbers of each kind of row.
pub trait Sold {
    /// It.
    fn offer(&self) -> &Offer;
    /// Where it is put.
    fn offer_mut(&mut self) -> &mut Offer;
}

impl Offer {
    /// The price, where there is one.
    pub fn price(&self) -> Option<Price> {
        Some(Price {
            value: self.price?,
            currency: Currency::of(&self.price_currency).ok()?,
            date: Date::read(&self.price_date).ok()?,
            quantity: self.price_quantity.unwrap_or(1.0),
        })
    }

    /// This offer, or another where it says nothing: a price is taken whole.
    #[must_use]
    pub fn or(self, other: &Offer) -> Offer {
        let lead_time = self.lead_time.or(other.lead_time);
        if self.price.is_some() { Offer { lead_time, ..self } } else { Offer { lead_time, ..other.clone() } }
    }

    /// Its mistakes.
    pub fn wrong(&self) -> Vec<Wrong> {
        let mut found = Vec::new();
        let mut need = |given: bool, said: bool, column: &'static str, of: &str| {
            if given && !said {
                found.push(Wrong {
                    column,
                    message: format!("`{column}` is given without `{of}`"),
                    label: "what does it refer to?",
                    help: "give both, or leave the number out and say it in the note".into(),
                });
            }
        };
        need(self.price.is_some(), !self.price_currency.is_empty(), "price", "price_currency");
        need(self.price.is_some(), !self.price_date.is_empty(), "price", "price_date");
        need(self.price_quantity.is_some(), self.price.is_some(), "price_quantity", "price");
        let mut text = |column: &'static str, text: &str, what: &str, read: Result<(), String>| {
            if let Some(help) = read.err().filter(|_| !text.is_empty()) {
                found.push(Wrong { column, message: format!("`{text}` is no {what}"), label: "in this row", help });
            }
        };
        text("price_currency", &self.price_currency, "currency", Currency::of(&self.price_currency).map(drop));
        text("price_date", &self.price_date, "day", Date::read(&self.price_date).map(drop));
        found
    }
}

/// The mistake of a column of a day, month or year.
pub fn wrong_day(column: &'static str, text: &str) -> Option<Wrong> {
    let help = Date::check_partly(text).err().filter(|_| !text.is_empty())?;
    Some(Wrong { column, message: format!("`{text}` is no day, month or year"), label: "in this row", help })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_in_order_and_of_three_letters() {
        assert!(CURRENCIES.is_sorted() && CURRENCIES.iter().all(|code| code.len() == 3));
        for code in CURRENCIES {
            assert_eq!(Currency::of(code).map(Currency::code), Ok(*code));
        }
        for bad in ["", "EURO", "€", "euro", "XYZ"] {
            assert!(Currency::of(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn days_are_those_of_the_calendar() {
        for good in ["2026-01-31", "2000-02-29", "2024-12-01"] {
            assert_eq!(Date::read(good).map(|date| date.to_string()), Ok(good.into()));
        }
        for bad in [
            "",
            "2026",
            "2026-11",
            "2026-11-31",
            "2026-13-01",
            "2026-00-10",
            "1900-02-29",
            "2026-11-00",
            "26-11-01",
            "2026.11.01",
            "2026-1-1",
            "Nov 2026",
        ] {
            assert!(Date::read(bad).is_err(), "{bad}");
        }
        let told = |text: &str| Date::read(text).unwrap_err();
        assert!(told("31.12.2026").ends_with("write 2026-12-31"));
        assert!(told("12/31/2026").ends_with("write 2026-12-31"));
        assert!(told("01-02-2026").ends_with("write 2026-02-01 or 2026-01-02"));
    }

    #[test]
    fn years_apart_are_those_of_the_calendar() {
        let apart = |a: &str, b: &str| Date::read(a).unwrap().is_within(2, Date::read(b).unwrap());
        assert!(apart("2024-02-29", "2026-02-28") && apart("2024-02-29", "2026-02-29".replace("29", "28").as_str()));
        assert!(!apart("2024-02-29", "2026-03-01") && !apart("2026-03-02", "2024-03-01"));
        assert!(apart("2026-03-01", "2024-03-01"));
    }

    #[test]
    fn a_price_is_taken_whole_from_another_offer() {
        let euro = Offer {
            price: Some(3.0),
            price_currency: "EUR".into(),
            price_date: "2026-01-01".into(),
            ..Offer::default()
        };
        let yuan = Offer {
            price: Some(20.0),
            price_quantity: Some(10.0),
            price_currency: "CNY".into(),
            price_date: "2025-01-01".into(),
            lead_time: Some(5.0),
        };
        assert_eq!(euro.clone().or(&yuan), Offer { lead_time: Some(5.0), ..euro });
        assert_eq!(
            Offer { lead_time: Some(1.0), ..Offer::default() }.or(&yuan),
            Offer { lead_time: Some(1.0), ..yuan }
        );
    }
}
